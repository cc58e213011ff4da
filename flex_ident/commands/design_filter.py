"""`flex_ident design-filter`: eqs. 22 to 29 with numbers, and Figure 1."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np

from flex_ident.errors import UsageError
from flex_ident.filtering.design import FilterDesign, difference_magnitude, filter_design, lowpass_magnitude
from flex_ident.report.folder import write_file

RATE_SHARE = 0.999
"""Share of the rate of eq. 29 from which a rate is that rate, rounded."""


def design_text(design: FilterDesign) -> str:
    """The design in words and numbers, one item a line."""
    lines = [
        f"first mode              {design.first_mode_hz:.4g} Hz",
        f"highest derivative      {design.derivative_order}",
        f"filter order (one pass) {design.order}",
        f"bandwidth               {design.bandwidth_rad_s:.2f} rad/s",
        f"Butterworth cutoff      {design.cutoff_rad_s:.2f} rad/s (eq. 28)",
        f"sampling rate needed    {design.required_rate_hz:.1f} Hz (eq. 29)",
        f"sampling rate           {design.sample_rate_hz:.2f} Hz",
        f"decimation              {design.decimation}, cutoff {design.decimation_cutoff_hz:.2f} Hz",
    ]
    if design.sample_rate_hz < RATE_SHARE * design.required_rate_hz:
        lines.append(
            f"warning: {design.sample_rate_hz:.4g} Hz is below the {design.required_rate_hz:.4g} Hz of eq. 29: central "
            "differences distort the derivatives inside the band. Record faster."
        )
    bandwidth_hz = design.bandwidth_rad_s / (2.0 * math.pi)
    if design.sample_rate_hz <= 2.0 * bandwidth_hz:
        lines.append(
            f"warning: the bandwidth, {bandwidth_hz:.4g} Hz, lies above half that rate: no such filter exists."
        )
    return "\n".join(lines)


def figure_1(design: FilterDesign, kind: str) -> bytes:
    """Figure 1 of the paper as a file of this kind: low-pass, central differences and their product over frequency.

    Raises ValueError for a kind that matplotlib does not write.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    nyquist = math.pi * design.sample_rate_hz
    omega = np.geomspace(0.01 * nyquist, 0.999 * nyquist, 400)
    low = lowpass_magnitude(omega, design.cutoff_rad_s, design.order)
    nd = design.derivative_order
    difference = difference_magnitude(omega, design.sample_rate_hz, nd)
    figure = Figure(figsize=(7, 4.5))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.loglog(omega, low, label="Butterworth, forward and back (eq. 25)")
    axes.loglog(omega, omega**nd * difference, label=f"{nd} central differences (eq. 24)")
    axes.loglog(omega, omega**nd * difference * low, label="band-limited derivative (eq. 26)")
    axes.axvline(design.bandwidth_rad_s, color="grey", linestyle=":", label="bandwidth")
    axes.set_xlabel("rad/s")
    axes.set_ylabel("magnitude")
    axes.set_ylim(1e-4, None)
    axes.legend()
    figure.tight_layout()
    content = io.BytesIO()
    figure.savefig(content, dpi=120, format=kind)
    return content.getvalue()


def design_filter(
    first_mode_hz: float,
    *,
    derivative_order: int = 2,
    order: int | None = None,
    sample_rate_hz: float | None = None,
    edge_gain: float = math.sqrt(0.5),
    ratio: float = 1.0,
    decimation: int | None = None,
    figure: Path | None = None,
) -> str:
    """Text of the design for a first mode; Figure 1 is drawn to `figure` when given. Raises UsageError."""
    design = filter_design(
        first_mode_hz, derivative_order=derivative_order, order=order, sample_rate_hz=sample_rate_hz,
        edge_gain=edge_gain, ratio=ratio, decimation=decimation,
    )  # fmt: skip
    if figure is not None:
        try:
            figure.parent.mkdir(parents=True, exist_ok=True)
            content = figure_1(design, figure.suffix.lstrip(".") or "png")
        except OSError as error:
            raise UsageError(f"--figure {figure}: cannot be written ({error.strerror}).") from error
        except ValueError as error:
            raise UsageError(f"--figure {figure}: {error}.") from error
        write_file(figure, content, "--figure")
    return design_text(design)
