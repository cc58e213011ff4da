"""A spring that hardens or softens."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.effects.starting import Scans, Shape, Start
from flex_ident.simulation.terms import Term

BENT = 0.02
"""Residual over torque, rms, from which the spring's law is scanned."""
HARDENINGS = (-0.1, -0.03, 0.01, 0.03, 0.1, 0.3)
"""Cubic over linear part of the spring's torque at the rms deflection of the best linear spring."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("cubic", scales.load / scales.deflection**3)


def _start(scans: Scans) -> Start | None:
    """How the spring hardens or softens: the best linear spring has its resonance elsewhere."""
    bend = scans.scales.deflection
    if scans.rigid or scans.residual < BENT * scans.scales.torque:
        return None

    def hardening(share: float) -> Shape:
        return lambda square: {Term.CUBIC_STIFFNESS: share * square / bend**2}

    which, model = scans.scanned_springs([hardening(share) for share in HARDENINGS])
    inertia = model["JL"]
    square = model["K"] / inertia
    return Start(model, {"cubic": HARDENINGS[which] * square / bend**2 * inertia})


NONLINEAR_STIFFNESS = Effect(
    name="nonlinear_stiffness",
    summary="hardening or softening spring",
    equation="tau + cubic d^3",
    parameters=(
        EffectParameter(
            "cubic",
            "N m/rad^3",
            "third-order coefficient of the spring, negative where it softens",
            Term.CUBIC_STIFFNESS,
        ),
    ),
    probes=_probes,
    start=_start,
    where="spring",
    signature="a residual odd in deflection that grows with its cube",
    bin_by="spring_deflection",
    confused_with=("load_dependent_friction", "backlash"),
    separated_by="two amplitudes",
    needs_spring=True,
)
