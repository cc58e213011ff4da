"""A user's simulation against the measurement, for a terminal."""

from __future__ import annotations

from flex_ident.gap.simulator import SimulatorGap
from flex_ident.report.table import rounded, text_table


def simulator_text(gap: SimulatorGap) -> str:
    """Parameters of the simulation beside the measured ones, and what it lacks."""
    rows = [
        (d.key, rounded(d.simulated.value, d.simulated.std), rounded(d.measured.value, d.measured.std),
         f"{d.percent:+.1f}", f"{d.sigmas:.1f}", d.measured.unit, "off" if d.off else "")
        for d in gap.differences
    ]  # fmt: skip
    table = text_table(("", "simulated", "measured", "off %", "σ", "unit", ""), rows, right=(1, 2, 3, 4))
    lacks = ", ".join(gap.lacks) if gap.lacks else "no effect that the measurement shows"
    text = f"the simulation against the measurement:\n{table}\nit lacks: {lacks}"
    if gap.has_too_much:
        text += f"\nit has what the measurement does not show: {', '.join(gap.has_too_much)}"
    return text
