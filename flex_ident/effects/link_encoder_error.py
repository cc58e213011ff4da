"""An error of the link's encoder that is periodic in its angle: once and twice a turn, as of an eccentric disk."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect
from flex_ident.effects.harmonics import harmonics
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import HARMONICS, LINK_ENCODER_ERRORS

TURNS = (1.0, 2.0)
"""Periods in a turn of the joint."""
SEEN = 0.9
"""Of a period within the range of motion from which it is tried: of less a link encoder's scale is as good."""


USUAL = 1e-4
"""Error, rad, one standard deviation of sine and cosine once and twice a turn, that an encoder may have unseen: a disk
eccentric by 5 um at a radius of 50 mm. Good encoders have a third of it, magnetic ones ten times as much."""


def _unseen(model: Values) -> tuple[Probe, ...]:
    """Sine and cosine once and twice a turn; beside an error in the model nothing."""
    if "link_encoder_error" in model.effects:
        return ()
    sines = (
        {"amplitude": USUAL, "cycles_per_turn": cycles, "phase": phase}
        for cycles in TURNS
        for phase in (0.0, 0.5 * math.pi)
    )
    return tuple(Probe((sine,), ("amplitude",), one_sided=False, smooth=True, phased=True) for sine in sines)


def _probes(scales: Scales) -> Iterator[Probe]:
    for cycles in TURNS:
        if cycles * scales.travel < SEEN * 2.0 * math.pi:
            continue
        sine = {"amplitude": SMOOTH_PROBE * scales.deflection, "cycles_per_turn": cycles, "phase": 0.0}
        yield Probe((sine, {**sine, "phase": 0.5 * math.pi}), ("amplitude",), one_sided=False, smooth=True, phased=True)


LINK_ENCODER_ERROR = Effect(
    name="link_encoder_error",
    summary="error of the link's encoder that is periodic in its angle (an eccentric disk)",
    equation="link position recorded = q + sum of amplitude sin(cycles_per_turn q + phase) over its harmonics",
    parameters=harmonics("rad", "amplitude of the error", LINK_ENCODER_ERRORS),
    probes=_probes,
    unseen=_unseen,
    cycles="cycles_per_turn",
    again=HARMONICS[: len(LINK_ENCODER_ERRORS)],
    where="measurement",
    signature="an error of the link position over its own angle that the torque knows nothing of",
    bin_by="motor_position",
    confused_with=("kinematic_error", "gravity"),
    separated_by="a turn and more, played slowly in both directions",
    needs_spring=True,
    needs_link=True,
    law_error=EXACT,
)
