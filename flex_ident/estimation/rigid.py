"""Would a rigid joint do as well? A spring must earn its place."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from flex_ident.errors import DataError
from flex_ident.estimation.base_fit import base_fit, rough_values
from flex_ident.estimation.estimate import Estimate, fit_problem, rigid_keys, started_values
from flex_ident.estimation.evidence import is_identifiable
from flex_ident.estimation.identified import modes_hz
from flex_ident.judgement.thresholds import GOOD_RIGID, MOST_RIGID, RIGID_MARGIN, SURELY_RIGID
from flex_ident.likelihood.nuisances import model_priors
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.parameters import JointModel
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording


class Asked(Protocol):
    """What an identification or an explanation may be asked for that decides whether the joint may be rigid."""

    @property
    def rigid(self) -> bool:
        """Whether it was said to be."""

    @property
    def sensors(self) -> str:
        """Which positions are to be used."""

    @property
    def band_hz(self) -> float | None:
        """Where the band ends, if given."""

    @property
    def first_mode_hz(self) -> float | None:
        """Its mode, if given."""

    @property
    def model(self) -> JointModel | None:
        """The model to start from, if given."""


def may_be_rigid(asked: Asked, sensors: str) -> bool:
    """Whether a rigid joint may be taken for what is fitted, unasked: unless a mode, or a model with a spring, is
    given, or the link's position is there to see the spring by."""
    return not asked.rigid and asked.first_mode_hz is None and asked.model is None and sensors != "motor+link"


def spring_is_open(estimate: Estimate) -> bool:
    """Whether the data leave the spring open: K, or an inertia where the mode lies above all that was excited."""
    fit = estimate.fit
    if not is_identifiable(estimate, "K"):
        return True
    outside = modes_hz(fit.values).get("locked_motor_hz", 0.0) > estimate.problem.band_hz
    return outside and not all(is_identifiable(estimate, k) for k in ("Jm", "JL") if k in fit.free)


def rigid_beside_link(recording: Recording, asked: Asked, *, prismatic: bool) -> Notice | None:
    """That a rigid joint may be tried by the motor alone, where the link's position, which nobody asked for, led to
    nothing; None where it may not, or leaves too much of the torque."""
    if asked.sensors != "auto" or not may_be_rigid(asked, "motor"):
        return None
    left = rigid_left_percent(recording, prismatic=prismatic, band_hz=asked.band_hz)
    if left is None or left > GOOD_RIGID:
        return None
    return Notice(Code.TAKEN_AS_RIGID, "K", {"rigid_percent": left}, {"case": "beside_link"})


def rigid_left_percent(
    recording: Recording, *, prismatic: bool, band_hz: float | None = None, resting_speed: float = 0.0,
    enough: float = 0.0,
) -> float | None:  # fmt: skip
    """How much of the torque a rigid joint leaves, percent, fitted as one with a spring is, in the band of that and
    while the motor is faster than `resting_speed`, rad/s; None where it cannot be.

    A first fit is all where that leaves more than `enough` and half as much again.
    """
    try:
        if band_hz is None:
            problem = fit_problem(recording, sensors="motor", rigid=True)
        else:
            problem = FitProblem(recording, sensors="motor", rigid=True, band_hz=band_hz)
        problem = problem.resting_below(resting_speed)
        keys, priors = rigid_keys(problem, gravity=not prismatic), model_priors(problem)
        start = rough_values(problem, keys, started_values(problem, keys), priors)
        if (left := _left_percent(problem, start)) > SURELY_RIGID * enough > 0.0:
            return left
        return _left_percent(problem, base_fit(problem, keys, start, priors)[1].values)
    except DataError:
        return None


def rigid_objection(recording: Recording, *, prismatic: bool, band_hz: float | None = None) -> str | None:
    """Why the recording is not that of a rigid joint either, as one line; None where it may be."""
    try:
        problem = fit_problem(recording, sensors="motor", rigid=True, band_hz=band_hz)
        started_values(problem, rigid_keys(problem, gravity=not prismatic))
    except DataError as error:
        return str(error)
    return None


def _left_percent(problem: FitProblem, values: Values) -> float:
    left, whole = problem.residuals(values)[0][problem.usable], problem.torque[problem.usable]
    return 100.0 * float(np.linalg.norm(left) / np.linalg.norm(whole))


def rigid_notice(
    recording: Recording,
    sprung_percent: float,
    *,
    open_spring: bool,
    prismatic: bool,
    band_hz: float | None = None,
    resting_speed: float = 0.0,
) -> Notice | None:
    """That a rigid joint does as well as one with a spring, which leaves `sprung_percent` of the torque of the same
    samples and is not determined where it is `open_spring`; None where the spring has earned its place.

    It has not where it leaves as much of the torque, or where it is not determined and a rigid joint leaves little. Of
    a motor alone only: with the link's position a spring can be measured that the torque does not show.
    """
    enough = max(min(RIGID_MARGIN * sprung_percent, MOST_RIGID), GOOD_RIGID if open_spring else 0.0)
    left = rigid_left_percent(
        recording, prismatic=prismatic, band_hz=band_hz, resting_speed=resting_speed, enough=enough
    )
    if left is None:
        return None
    undetermined = open_spring and left < GOOD_RIGID
    if not undetermined and not left <= min(RIGID_MARGIN * sprung_percent, MOST_RIGID):
        return None
    return Notice(Code.RIGID_AS_WELL, "K", {"rigid_percent": left, "sprung_percent": sprung_percent})
