"""Stage 6: how likely a recording is under a model: the problem, its noise, its fit, its uncertainty, what is left."""
