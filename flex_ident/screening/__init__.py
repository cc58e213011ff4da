"""Stage 7: what each effect of the catalogue would explain of what a model leaves, without a full refit."""
