"""Friction that falls as speed rises from zero (Stribeck)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.notices import Reason, Why
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    for side in scales.sides:
        for share in (0.03, 0.08, 0.2, 0.5):
            shape = {f"amplitude{side}": 0.02 * scales.torque, f"velocity{side}": share * scales.speed}
            yield at_size(shape, scaled=(f"amplitude{side}",))


LARGEST_SHARE = 3.0
"""Peak over the dry friction that it rises from: break-away is up to a few times the friction in motion."""


def _reach(own: Mapping[str, float], model: Values) -> Reason | None:
    dry = sum(abs(model.get(k, 0.0)) for k in ("FSm", "FS"))
    peak = max(own["amplitude"], own["amplitude_link"])
    if peak <= LARGEST_SHARE * dry:
        return None
    return Reason(Why.PEAK_WITHOUT_FRICTION, numbers={"peak": peak, "dry": dry})


STRIBECK_FRICTION = Effect(
    name="stribeck_friction",
    summary="friction falls as speed rises from zero",
    equation="amplitude exp(-(v / velocity)^2) sign(v)",
    parameters=(
        EffectParameter("amplitude", "N m", "excess of dry friction at standstill", Term.MOTOR_STRIBECK, lower=0.0),
        EffectParameter(
            "velocity", "rad/s", "speed at which the excess has fallen to 1/e", Term.MOTOR_STRIBECK_VELOCITY, lower=1e-9
        ),
        EffectParameter("amplitude_link", "N m", "the same on the link", Term.LINK_STRIBECK, lower=0.0),
        EffectParameter("velocity_link", "rad/s", "the same on the link", Term.LINK_STRIBECK_VELOCITY, lower=1e-9),
    ),
    probes=_probes,
    reach=_reach,
    where="motor",
    signature="peaks of torque just after each reversal, odd in velocity, gone at speed",
    bin_by="motor_velocity",
    confused_with=("viscous_nonlinearity",),
    at_reversals=True,
    separated_by="slow and fast motion at constant speed",
)
