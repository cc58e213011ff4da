"""Joints to test the estimator on that share nothing with it: no import of flex_ident, own integrators, own friction.

`cases.case_of(seed, i)` says what recording i is; `experiment.made(case)` plays it.
"""

from plants.cases import Case, case_of
from plants.experiment import CaseError, Made, made

__all__ = ["Case", "CaseError", "Made", "case_of", "made"]
