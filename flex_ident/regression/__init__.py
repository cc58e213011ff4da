"""Stage 3: eq. 13, eqs. 14-20 with Table 3, the rigid joint, and their least squares."""

from flex_ident.regression.identification import identify_linear
from flex_ident.regression.least_squares import LinearFit, least_squares

__all__ = ["LinearFit", "identify_linear", "least_squares"]
