"""Stage 3: the paper's linear models and their least squares."""
