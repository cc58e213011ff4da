"""The look that all figures share, and their way to PNG and into a page."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording import Floats

MEASURED = "#1f3a5f"
PREDICTED = "#d1495b"
LINK = "#2a9d8f"
QUIET = "#8d99ae"
STYLE = {
    "font.size": 9.5, "axes.titlesize": 10.5, "axes.titlelocation": "left", "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True, "grid.color": "#e6e8ec",
    "grid.linewidth": 0.7, "axes.edgecolor": "#6c757d", "axes.labelcolor": "#333333", "xtick.color": "#555555",
    "ytick.color": "#555555", "legend.frameon": False, "legend.fontsize": 8.5, "lines.linewidth": 1.2,
    "figure.dpi": 110,
}  # fmt: skip
POINTS = 3000


@contextmanager
def styled_figure(width: float, height: float) -> Iterator[Any]:
    """A figure, inches, drawn without a display and in the shared look."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure


def thinned(time: Floats, values: Floats, points: int = POINTS) -> tuple[Floats, Floats]:
    """At most `points` samples with the extremes of each stretch kept, so that a fast chirp stays an envelope.

    NaN stays where a whole stretch is NaN: the line is interrupted there.
    """
    if time.size <= points:
        return time, values
    size = -(-2 * time.size // points)
    usable = time.size // size * size
    blocks = values[:usable].reshape(-1, size)
    missing = np.isnan(blocks)
    low = np.where(missing, np.inf, blocks).argmin(axis=1)
    high = np.where(missing, -np.inf, blocks).argmax(axis=1)
    pairs = np.sort(np.stack((low, high), axis=1), axis=1) + size * np.arange(blocks.shape[0])[:, None]
    index = pairs.ravel()
    return time[index], values[index]


def plain_log_ticks(axis: Any) -> None:
    """Ticks of a logarithmic axis at 1, 2, 5 of each decade (closer on a short axis), in plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = axis.get_view_interval()
    decades = float(np.log10(high / low)) if 0.0 < low < high else 1.0
    subs = (1, 1.5, 2, 3, 4, 5, 6, 8) if decades < 1.05 else (1, 2, 5) if decades < 3.5 else (1,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=30))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _position: f"{value:g}"))


def runs(marks: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and past-last index of each stretch of True in `marks` (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], marks.astype(int), [0]))))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def png_bytes(figure: Any) -> bytes:
    """The figure as a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def embedded(png: bytes) -> str:
    """A PNG as the address of an image inside a page."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def write_pngs(figures: dict[str, bytes], folder: Path) -> list[Path]:
    """Write each PNG under its name; the paths written."""
    paths = []
    for name, png in figures.items():
        path = folder / f"{name}.png"
        path.write_bytes(png)
        paths.append(path)
    return paths
