"""A drive that delivers less of the torque it is asked for as it turns faster."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import BEYOND_THE_LAW, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("loss", 1.0 / scales.speed**2, one_sided=True)


TORQUE_DROOP = Effect(
    name="torque_droop",
    summary="drive that delivers less of the torque as it turns faster",
    equation="delivered = recorded / (1 + loss v^2)",
    parameters=(
        EffectParameter(
            "loss",
            "s^2/rad^2",
            "share of the torque that is lost, over the speed squared",
            Term.TORQUE_DROOP,
            lower=0.0,
        ),
    ),
    probes=_probes,
    where="measurement",
    scales_torque=BEYOND_THE_LAW,
    signature="a residual against the torque that grows with speed",
    bin_by="motor_velocity",
    confused_with=("viscous_nonlinearity", "saturation"),
    separated_by="a lower speed, or the measured torque instead of the commanded one",
)
