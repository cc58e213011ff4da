"""What a cable, a hose or a balancing spring pulls the link with: a spring to ground, or one on a lever."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales, at_size
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import GRAVITY, Term

CONSTANTS = ("offset", "torque_offset.offset")
"""Keys of a constant torque on the motor: it is that of a cable as well, and is in the model once."""
USUAL_SPRING, USUAL_LEVER = 0.1, 0.05
"""What may be in any joint, one standard deviation: the slope of a spring over that of gravity where gravity is
steepest, and the torque of half gravity's period over gravity's. Set by hand, for cables and hoses: a balancing spring
takes up to half, and who has one knows it (`explain_gap --add cable_torque`)."""


def _probes(scales: Scales) -> Iterator[Probe]:
    spring, pull = SMOOTH_PROBE * scales.torque / scales.travel, SMOOTH_PROBE * scales.torque
    constant = () if any(key in scales.model for key in CONSTANTS) else ("torque",)
    for sizes in ({"stiffness": spring}, {"cosine": pull, "sine": pull}):
        names = (*sizes, *constant)
        columns = tuple({k: sizes.get(k, pull) * (k == own) for k in names} for own in names)
        yield Probe(columns, names, one_sided=False, smooth=True)


def _unseen(model: Values) -> tuple[Probe, ...]:
    """All of it, or beside a spring in the model the constant that may as well be on the motor: it bends the joint, and
    turns gravity."""
    if "cable_torque" in model.effects:
        constant = max((abs(model[key]) for key in CONSTANTS if key in model), default=0.0)
        return () if "torque" in model.effects["cable_torque"] or constant == 0.0 else (at_size({"torque": constant}),)
    weight = GRAVITY * math.hypot(model.get("MX", 0.0), model.get("MY", 0.0))
    if weight == 0.0:
        return ()
    sizes = {"stiffness": USUAL_SPRING, "cosine": USUAL_LEVER, "sine": USUAL_LEVER}
    return tuple(at_size({key: share * weight}) for key, share in sizes.items())


CABLE_TORQUE = Effect(
    name="cable_torque",
    summary="cable, hose or balancing spring that pulls the link towards a position of its own",
    equation="stiffness q + torque + cosine cos 2q + sine sin 2q, on the link: a spring rests at -torque / stiffness",
    parameters=(
        EffectParameter("stiffness", "N m/rad", "of the spring from link to ground", Term.CABLE_STIFFNESS),
        EffectParameter("torque", "N m", "its torque where the position is zero", Term.CABLE_TORQUE),
        EffectParameter("cosine", "N m", "of a spring on a lever: times cos 2q", Term.CABLE_COS_2),
        EffectParameter("sine", "N m", "likewise times sin 2q", Term.CABLE_SIN_2),
    ),
    probes=_probes,
    unseen=_unseen,
    where="link",
    signature="a residual that is a straight line over position, where gravity bends, or bends twice as fast",
    bin_by="motor_position",
    confused_with=("gravity", "torque_offset"),
    separated_by="a range of positions over which the sine of gravity bends, a radian and more, played slowly",
)
