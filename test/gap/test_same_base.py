"""`identify` and `explain` fit the same model to the same samples: where nothing is hidden they leave the same."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flex_ident.estimation.estimate import estimated, fit_problem, validation_blocks
from flex_ident.estimation.identification import base_start, identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions, explain
from flex_ident.gap.base import fitted_base
from flex_ident.gap.sizes import gap_size
from flex_ident.likelihood.remainder import remainder
from flex_ident.parameters import JointModel
from flex_ident.recording import Recording
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

FEW = ("friction_drift",)
"""The catalogue that is searched: what it holds is not the matter here."""
FLAT = JointModel({k: v for k, v in COBOT_JOINT.parameters.items() if k not in ("MX", "MY")})
RIGID = JointModel({"J": 1.2, "FV": 3.0, "FS": 1.0, "MX": 2.0, "MY": 1.0})


@cache
def recorded(kind: str) -> Recording:
    if kind == "rigid":
        t = np.arange(0.0, 20.0, 2e-3)
        phase, omega = 2 * np.pi * (0.2 * t + 0.1 * t**2), 2 * np.pi * (0.2 + 0.2 * t)
        q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
        a = 0.3 * (2 * np.pi * 0.2 * np.cos(phase) - omega**2 * np.sin(phase))
        load = 9.81 * (RIGID.value("MX") * np.cos(q) + RIGID.value("MY") * np.sin(q))
        torque = RIGID.value("J") * a + RIGID.value("FV") * v + RIGID.value("FS") * np.sign(v) + load
        return Recording("j", 500.0, q, torque + np.random.default_rng(0).normal(0.0, 0.3, t.size))
    model = {"cobot": COBOT_JOINT, "flat": FLAT}[kind]
    experiment = Experiment(duration_s=10.0, sample_rate_hz=500.0)
    return virtual_recording(model, experiment, MeasurementChain(torque_noise=0.01), seed=2)


Row = tuple[str, IdentifyOptions, bool, GapOptions]
"""Recording, what identify is given, whether it slides, what explain is given."""
ROWS: dict[str, Row] = {
    "motor": ("cobot", IdentifyOptions(sensors="motor"), False, GapOptions(sensors="motor", effects=FEW)),
    "motor+link": ("cobot", IdentifyOptions(), False, GapOptions(effects=FEW)),
    "rigid": ("rigid", IdentifyOptions(rigid=True), False, GapOptions(rigid=True, effects=FEW)),
    "prismatic": ("flat", IdentifyOptions(), True, GapOptions(prismatic=True, effects=FEW)),
    # a joint on which gravity does not act: without its moments explain fits what identify fits of one that slides
    "without MX,MY": ("flat", IdentifyOptions(), True, GapOptions(without=("MX", "MY"), effects=FEW)),
}
LONG = ("motor", "prismatic", "without MX,MY")
EVERY = pytest.mark.parametrize("row", list(ROWS.values()), ids=list(ROWS))
MOST = pytest.mark.parametrize(
    "row", [pytest.param(r, id=n, marks=pytest.mark.campaign if n in LONG else ()) for n, r in ROWS.items()]
)


@pytest.mark.slow
@EVERY
def test_base_of_explain_is_what_identify_fits(row: Row) -> None:
    kind, options, slides, gap = row
    recording = recorded(kind)
    sensors = "motor" if options.sensors == "motor" or recording.link_position is None else "motor+link"
    problem = fit_problem(recording, sensors=sensors, rigid=options.rigid)
    estimate = estimated(problem, *base_start(problem, options, prismatic=slides), prismatic=slides)
    kinds = fitted_base(problem, gap).kinds
    solver, base = kinds.solver, kinds.fit
    assert base.free == estimate.fit.free
    for key in base.free:
        assert base.values[key] == pytest.approx(estimate.fit.values[key], rel=1e-9, abs=1e-15), key
    left = remainder(solver, base)
    assert left.gap == pytest.approx(estimate.left.gap, rel=1e-9)
    assert left.floor == pytest.approx(estimate.left.floor, rel=1e-9)
    assert left.evidence == estimate.left.evidence
    held = validation_blocks(problem)  # the gap is of the samples that its noise is of: not where the motor sticks
    assert gap_size(problem, base.values, held).torque == pytest.approx(remainder(solver, base, held).gap, rel=1e-9)


@pytest.mark.slow
@MOST
def test_both_leave_the_same_where_nothing_is_hidden(row: Row) -> None:
    kind, options, slides, gap = row
    identified = identify(recorded(kind), options, prismatic=slides)
    explained = explain(recorded(kind), gap)
    assert explained.verdict == "complete"
    assert explained.findings == ()
    final = explained.final
    assert final.fit.relative_error_percent == pytest.approx(identified.fit.relative_error_percent, rel=1e-9)
    assert final.verdict == identified.verdict
    assert [p.key for p in final.parameters] == [p.key for p in identified.parameters]
    for p in identified.parameters:
        assert final.parameter(p.key).value == pytest.approx(p.value, rel=1e-9, abs=1e-12), p.key
        assert final.parameter(p.key).std == pytest.approx(p.std, rel=1e-6), p.key
