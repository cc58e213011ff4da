"""The pictures of an identification: signals, frequency response, Figure 2 of the paper, estimates over the cutoff."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import FlexIdentError
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters import CutoffSweep, FrequencyResponse, Identification, TorqueCurves
from flex_ident.recording import Recording
from flex_ident.report.figures import (
    LINK,
    MEASURED,
    PREDICTED,
    QUIET,
    plain_log_ticks,
    png_bytes,
    runs,
    styled_figure,
    thinned,
)
from flex_ident.report.friction import friction_plot, law_of
from flex_ident.report.units import Words, as_they_are, words_of

WINDOW_CYCLES_S = 3.0
"""Length of the close-up in Figure 2, s."""


def signals_plot(recording: Recording, words: Words = as_they_are) -> bytes:
    """Position, spring deflection where it was measured, and torque over time."""
    rows = 3 if recording.link_position is not None else 2
    with styled_figure(8.6, 1.75 * rows) as figure:
        axes = figure.subplots(rows, 1, sharex=True)
        t = recording.time
        axes[0].plot(*thinned(t, recording.motor_position), color=MEASURED, label="motor")
        if recording.reference is not None:
            axes[0].plot(*thinned(t, recording.reference), color=QUIET, lw=0.8, label="reference", zorder=0)
            axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        axes[0].set_ylabel(words("position, rad"))
        axes[0].set_title("What was recorded")
        if recording.link_position is not None:
            deflection = recording.motor_position - recording.link_position
            axes[1].plot(*thinned(t, 1e3 * (deflection - np.median(deflection))), color=LINK)
            axes[1].set_ylabel("motor minus\nlink, " + words("mrad"))
        axes[-1].plot(*thinned(t, recording.motor_torque), color=MEASURED)
        axes[-1].set_ylabel(words("torque, N m"))
        axes[-1].set_xlabel("time, s")
        _shade_gaps(axes, recording)
        return png_bytes(figure)


def _shade_gaps(axes: list, recording: Recording) -> None:  # type: ignore[type-arg]
    missing = ~recording.measured if recording.measured is not None else np.zeros(0, bool)
    for start, stop in runs(missing)[:200]:
        for a in axes:
            a.axvspan(start / recording.sample_rate_hz, stop / recording.sample_rate_hz, color=QUIET, alpha=0.3, lw=0)


def frequency_response_plot(response: FrequencyResponse, words: Words = as_they_are) -> bytes:
    """Apparent inertia and coherence over frequency with the fitted modes."""
    with styled_figure(8.6, 3.9) as figure:
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        top.loglog(response.frequency_hz, response.magnitude, color=MEASURED)
        names = ("locked motor", "free") if len(response.modes_hz) == 2 else ("mode",) * len(response.modes_hz)
        for mode, name, colour in zip(response.modes_hz, names, (PREDICTED, LINK), strict=False):
            for a in (top, bottom):
                a.axvline(mode, color=colour, ls="--", lw=1.0)
            top.plot([], [], color=colour, ls="--", lw=1.0, label=f"{name} {mode:.3g} Hz")
        if response.modes_hz:
            top.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        top.set_ylabel("torque over acceleration,\n" + words("kg m²"))
        top.set_title("Apparent inertia (peak: locked motor, dip: free resonance)")
        bottom.semilogx(response.frequency_hz, response.coherence, color=QUIET)
        bottom.set_ylim(0, 1.05)
        bottom.set_ylabel("coherence")
        bottom.set_xlabel("frequency, Hz")
        plain_log_ticks(top.yaxis)
        plain_log_ticks(bottom.xaxis)
        return png_bytes(figure)


def torque_plot(curves: TorqueCurves, fitted: NDArray[np.bool_] | None = None, words: Words = as_they_are) -> bytes:
    """Figure 2 of the paper: measured and predicted torque, their difference, and a close-up.

    Where `fitted` (n,) is False the difference is not drawn, and the time is shaded, as it is where samples are missing
    between the curves' own.
    """
    t, residual = curves.time, curves.measured - curves.predicted
    jumps = np.concatenate((np.diff(t) > 1.5 * float(np.median(np.diff(t))), [False]))
    used = np.ones(t.size, bool) if fitted is None else fitted
    shown = used & ~jumps
    with styled_figure(8.6, 5.4) as figure:
        whole, error, close = figure.subplots(3, 1, height_ratios=(2, 1.2, 2))
        whole.plot(*thinned(t, curves.measured), color=MEASURED, label="measured")
        whole.plot(*thinned(t, curves.predicted), color=PREDICTED, lw=0.8, label="predicted")
        whole.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        whole.set_ylabel(words("torque, N m"))
        whole.set_title("Measured and predicted torque, filtered alike (as Figure 2 of the paper)")
        error.plot(*thinned(t, np.where(shown, residual, np.nan)), color=QUIET, label="fitted")
        held = np.where(curves.validation & shown, residual, np.nan)
        error.plot(*thinned(t, held), color=LINK, lw=0.9, label="kept for validation")
        out = [(t[a], t[b - 1]) for a, b in runs(~used)]
        out += [(t[i], t[i + 1]) for i in np.flatnonzero(jumps)]
        for i, (a, b) in enumerate(out):
            for axes in (whole, error, close):
                label = "left out: edges, standstill, gaps" if i == 0 else None
                axes.axvspan(a, b, color=QUIET, alpha=0.22, lw=0, label=label, zorder=0)
        error.legend(loc="lower right", bbox_to_anchor=(1.0, 0.93), ncols=3)
        error.set_ylabel(words("error, N m"))
        error.sharex(whole)
        start = _liveliest(curves)
        part = (t >= start) & (t <= start + WINDOW_CYCLES_S)
        close.plot(t[part], curves.measured[part], color=MEASURED)
        close.plot(t[part], curves.predicted[part], color=PREDICTED, lw=1.0, ls="--")
        close.set_xlim(start, start + WINDOW_CYCLES_S)
        close.set_ylabel(words("close-up, N m"))
        close.set_xlabel("time, s")
        return png_bytes(figure)


def fitted_rows(result: Identification, recording: Recording) -> NDArray[np.bool_] | None:
    """Which rows (n,) of the result's curves the fit used; None when it is all of them, as in a regression."""
    curves = result.curves
    if curves is None or result.filter is None or curves.time.size == result.fit.samples:
        return None
    band_hz = result.filter.bandwidth_rad_s / (2.0 * np.pi)
    try:
        rows = FitProblem(recording, sensors=result.sensors, rigid=result.model.rigid, band_hz=band_hz).usable
    except FlexIdentError:
        return None
    return rows if rows.size == curves.time.size else None


def _liveliest(curves: TorqueCurves) -> float:
    """Where the close-up starts: around the middle of the torque's energy."""
    energy = np.cumsum((curves.measured - curves.measured.mean()) ** 2)
    middle = int(np.searchsorted(energy, 0.5 * energy[-1]))
    last = float(curves.time[-1]) - WINDOW_CYCLES_S
    return max(float(curves.time[0]), min(float(curves.time[middle]) - 0.5 * WINDOW_CYCLES_S, last))


def cutoff_sweep_plot(sweep: CutoffSweep, used_rad_s: float) -> bytes:
    """Each estimate, relative to its value at the filter used, against the filter's cutoff."""
    keys = list(sweep.values)
    columns = 2 if len(keys) > 1 else 1
    rows = -(-len(keys) // columns)
    with styled_figure(8.6, 1.7 * rows + 0.4) as figure:
        axes = np.atleast_1d(figure.subplots(rows, columns, sharex=True)).ravel()
        for a, key in zip(axes, keys, strict=False):
            value, std = sweep.values[key], sweep.stds[key]
            a.fill_between(sweep.cutoff_rad_s, value - 2 * std, value + 2 * std, color=MEASURED, alpha=0.15, lw=0)
            a.plot(sweep.cutoff_rad_s, value, "o-", ms=3, color=MEASURED)
            a.axvline(used_rad_s, color=PREDICTED, ls="--", lw=1)
            a.set_title(key)
        for a in axes[len(keys) :]:
            a.set_visible(False)
        for a in axes[-columns:]:
            a.set_xlabel("cutoff, rad/s")
        return png_bytes(figure)


def identification_figures(result: Identification, recording: Recording) -> dict[str, bytes]:
    """Every picture of a result as PNG, by file name."""
    words = words_of(result)
    figures = {"signals": signals_plot(recording, words)}
    if result.frequency_response is not None and result.frequency_response.frequency_hz.size > 3:
        figures["frequency_response"] = frequency_response_plot(result.frequency_response, words)
    if result.curves is not None:
        figures["torque"] = torque_plot(result.curves, fitted_rows(result, recording), words)
    if result.cutoff_sweep is not None and result.filter is not None:
        figures["cutoff_sweep"] = cutoff_sweep_plot(result.cutoff_sweep, result.filter.cutoff_rad_s)
    if result.friction_curve is not None:
        figures["friction"] = friction_plot(result.friction_curve, law_of(result), words)
    return figures
