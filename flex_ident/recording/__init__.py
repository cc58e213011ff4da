"""Stage 1: what was recorded, validated and on one uniform clock."""

from flex_ident.recording.recording import Floats, Recording, Sampling, Signal, extent_text, more_needed
from flex_ident.recording.weight import Weight

__all__ = ["Floats", "Recording", "Sampling", "Signal", "Weight", "extent_text", "more_needed"]
