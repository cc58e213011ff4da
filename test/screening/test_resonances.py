"""A resonance that is small is tried as one: what it changes is in proportion to it, as no larger one's is."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flex_ident.effects import CATALOGUE
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.nuisances import model_priors
from flex_ident.likelihood.problem import FitProblem, values_of
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters import FLEXIBLE_KEYS
from flex_ident.screening.candidates import Candidate, scales_of
from flex_ident.screening.scoring import orthonormal, whitened_change
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

BASE = {"inertia": 60.0, "hz": 8.0, "ratio": 0.02}
"""Inertia over the joint's; a base of the joint's own mode."""


@cache
def beside_a_base() -> tuple[SteadyFit, Fit]:
    """A joint on a base of sixty times its inertia, fitted without."""
    total = COBOT_JOINT.value("Jm") + COBOT_JOINT.value("JL")
    inertia, omega = BASE["inertia"] * total, 2.0 * np.pi * BASE["hz"]
    base = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 2.0 * BASE["ratio"] * inertia * omega}
    joint = COBOT_JOINT.with_effect("mount_mode", base)
    experiment = Experiment(duration_s=12.0, sample_rate_hz=500.0, end_frequency_hz=30.0)
    recording = virtual_recording(joint, experiment, MeasurementChain(torque_noise=0.002), seed=2, link=False)
    problem = FitProblem(recording, sensors="motor", rigid=False, band_hz=30.0)
    solver = SteadyFit(problem, priors=model_priors(problem))
    values = values_of(COBOT_JOINT) | {"offset": 0.0}
    return solver, solver.solve(FLEXIBLE_KEYS, values, solver.whitenings(values), iterations=6)


@pytest.mark.parametrize("effect", ["mount_mode", "second_mode"])
def test_what_a_small_resonance_changes_is_in_proportion_to_it(effect: str) -> None:
    solver, fit = beside_a_base()
    scales = scales_of(solver.problem, fit.values, prismatic=False)
    small = [p for p in CATALOGUE[effect].probes(scales) if p.smooth]
    assert small
    basis = orthonormal(fit, "")
    for probe in small[:: max(1, len(small) // 8)]:
        (column,) = Candidate(effect, probe).probes
        half = {k: probe.sized(v, 0.5) for k, v in column.items()}
        whole, less = (whitened_change(solver, fit, fit.values | v) for v in (column, half))
        whole, less = (c - basis @ (basis.T @ c) for c in (whole, less))
        assert np.linalg.norm(whole - 2.0 * less) < 0.06 * np.linalg.norm(whole)
