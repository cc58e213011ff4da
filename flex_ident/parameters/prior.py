"""What is known of a parameter before the data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Prior:
    """What is known of a nuisance before the data: mean and standard deviation, and hard bounds."""

    mean: float
    std: float
    lower: float
    upper: float
    start: float = 0.0
    """Where a fit starts."""
