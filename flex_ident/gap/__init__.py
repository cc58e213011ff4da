"""Stages 6 and 7: where simulation and measurement disagree, and what is missing."""
