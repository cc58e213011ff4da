"""Identification of flexible robot joints from one recorded chirp, and of what the model lacks."""

__version__ = "0.1.0"
