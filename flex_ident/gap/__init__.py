"""Stages 6 and 7: where simulation and measurement disagree, and what is missing."""

from flex_ident.gap.explain import explain
from flex_ident.gap.explanation import GapExplanation
from flex_ident.gap.options import GapOptions

__all__ = ["GapExplanation", "GapOptions", "explain"]
