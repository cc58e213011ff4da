"""How far a result may be trusted: numbers in, a verdict and what speaks against a better one out."""
