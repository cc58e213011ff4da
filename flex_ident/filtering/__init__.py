"""Stage 2: band-limited derivatives without phase shift, the design of their filter, and the first mode."""

from flex_ident.filtering.band import excited_band_hz
from flex_ident.filtering.derivatives import central_differences, decimated, zero_phase_lowpass
from flex_ident.filtering.design import FilterDesign, butterworth_cutoff_rad_s, filter_design, sampling_rate_hz
from flex_ident.filtering.frequency_response import FirstMode, first_mode
from flex_ident.filtering.spectral import SpectralFilter

__all__ = [
    "FilterDesign", "FirstMode", "SpectralFilter", "butterworth_cutoff_rad_s", "central_differences", "decimated",
    "excited_band_hz", "filter_design", "first_mode", "sampling_rate_hz", "zero_phase_lowpass",
]  # fmt: skip
