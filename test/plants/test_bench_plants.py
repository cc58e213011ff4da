"""The plants of `bench/plants`: two integrators agree with each other and with closed forms; sticking is sticking."""

import ast
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from plants import case_of, made  # noqa: E402
from plants.drive import CONTROLLERS, TORQUE, Drive  # noqa: E402
from plants.events import run_events  # noqa: E402
from plants.excitation import EXCITATIONS  # noqa: E402
from plants.hidden import EFFECTS  # noqa: E402
from plants.joints import SIZES  # noqa: E402
from plants.laws import Joint, gravity_load  # noqa: E402
from plants.measurement import Chain, recorded  # noqa: E402
from plants.stepping import run_stepping  # noqa: E402

TICK = 1e-3
COBOT = SIZES["cobot"].joint
BOTH = pytest.mark.parametrize(("run", "sub"), [(run_stepping, 32), (run_events, 8)], ids=["stepping", "events"])


def played(run, sub: int, joint: Joint, torque: NDArray[np.float64], q0: float = 0.0, tick: float = TICK):
    """Motion (n, 6) under torques that are held over each tick."""
    drive = Drive(TORQUE, tick, 0.0, 0.0, 0.0, 1.0, 1e-9, 0.5)
    still = np.zeros(torque.size)
    return run(joint, drive, torque, still, still, q0, sub)


@pytest.mark.slow
@BOTH
def test_step_of_torque_without_friction_is_the_closed_form(run, sub: int) -> None:
    joint = Joint(1.5, 12000.0, 2.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    ticks = played(run, sub, joint, np.full(500, 7.0))
    t = np.arange(500) * TICK
    omega = 2.0 * np.pi * joint.free_hz()
    turned = 7.0 / joint.Jm / omega**2 * (1.0 - np.cos(omega * t))
    middle = 0.5 * 7.0 / (joint.Jm + joint.JL) * t * t
    share = joint.Jm / (joint.Jm + joint.JL)
    assert np.max(np.abs(ticks[:, 0] - middle - (1.0 - share) * turned)) < 2e-5 * np.max(middle)
    assert np.max(np.abs(ticks[:, 1] - middle + share * turned)) < 2e-5 * np.max(middle)


@BOTH
def test_mass_slides_to_rest_where_dry_friction_stops_it(run, sub: int) -> None:
    joint = Joint(2.0, 1e5, 1e-3, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0)
    torque = np.zeros(1000)
    torque[:100] = 9.0  # accelerates at 3, then slows at 1.5 rad/s^2 from 0.3 rad/s
    ticks = played(run, sub, joint, torque)
    assert ticks[-1, 0] == pytest.approx(0.015 + 0.03, rel=2e-3)
    assert np.all(ticks[320:, 5] == 0.0)


@BOTH
def test_joint_sticks_exactly_below_its_dry_friction(run, sub: int) -> None:
    hold = gravity_load(COBOT, 0.4)
    wave = np.sin(2.0 * np.pi * 2.0 * np.arange(2000) * TICK)
    held = played(run, sub, COBOT, hold + 0.99 * COBOT.FSm * wave, 0.4)
    assert np.all(held[:, 5] == 0.0)
    assert np.ptp(held[:, 0]) == np.ptp(held[:, 1]) == 0.0
    loose = played(run, sub, COBOT, hold + 1.2 * COBOT.FSm * wave, 0.4)
    assert np.ptp(loose[:, 0]) > 0.0
    assert 0.05 < np.mean(loose[:, 5] == 0.0) < 0.95


def test_integrators_agree_through_reversals_and_sticking() -> None:
    t = np.arange(4000) * TICK
    torque = gravity_load(COBOT, 2.8) + 14.0 * np.sin(2.0 * np.pi * (1.0 + 3.0 * t) * t)
    one = played(run_stepping, 32, COBOT, torque, 2.8)
    two = played(run_events, 8, COBOT, torque, 2.8)
    assert np.mean(two[:, 5] == 0.0) > 0.02
    for column in (0, 1):
        assert np.std(one[:, column] - two[:, column]) < 2e-4 * np.std(two[:, column])
    smooth = played(run_events, 32, COBOT._replace(tanh_speed=1e-4), torque, 2.8)
    assert np.std(smooth[:, 0] - two[:, 0]) < 2e-2 * np.std(two[:, 0])


def test_work_is_energy_and_heat() -> None:
    tick, joint = 1.0 / 32000.0, COBOT._replace(MX=0.0, MY=0.0)
    t = np.arange(64000) * tick
    torque = 20.0 * np.sin(2.0 * np.pi * (1.0 + 4.0 * t) * t)
    ticks = played(run_stepping, 1, joint, torque, 0.0, tick)
    qm, q, wm = ticks[:, 0], ticks[:, 1], ticks[:, 5]
    w = np.gradient(q, tick)
    work = np.sum(torque[:-1] * np.diff(qm))
    stored = 0.5 * (joint.Jm * wm[-1] ** 2 + joint.JL * w[-1] ** 2 + joint.K * (qm[-1] - q[-1]) ** 2)
    dry = joint.FSm * np.sum(np.abs(np.diff(qm))) + joint.FS * np.sum(np.abs(np.diff(q)))
    viscous = tick * (joint.FVm * np.sum(wm**2) + joint.FV * np.sum(w**2))
    assert work == pytest.approx(stored + dry + viscous, rel=1e-3)
    assert dry > 0.1 * work


def test_plants_do_not_know_the_estimator() -> None:
    for path in (BENCH / "plants").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("flex_ident")], path.name


def test_sixty_recordings_meet_everything() -> None:
    cases = [case_of(1, i) for i in range(60)]
    assert {c.joint for c in cases} == set(SIZES)
    assert {(c.controller, c.excitation) for c in cases} == {(a, b) for a in CONTROLLERS for b in EXCITATIONS}
    assert {(c.controller, c.joint) for c in cases} == {(a, b) for a in CONTROLLERS for b in SIZES}
    assert {c.rate_hz for c in cases} == {100.0, 250.0, 500.0, 1000.0, 2000.0}
    assert {c.stratum for c in cases} == {"standard", "slow", "lag"}
    assert {(c.effect, c.size) for c in (case_of(1, i, True) for i in range(63))} == {
        (e, s) for e in EFFECTS for s in range(3)
    }


def test_recording_is_its_seed_and_index() -> None:
    one, two, other = (made(case_of(seed, 1)) for seed in (1, 1, 2))
    assert one.truth == two.truth
    assert np.array_equal(one.recorded.motor_torque, two.recorded.motor_torque)
    assert one.truth != other.truth


@pytest.mark.parametrize(("effort", "late"), [("command", 0.0), ("delivered", 0.0), ("mean", 0.5)])
@pytest.mark.parametrize("delay", [0.0, 2.5])
def test_effort_is_late_by_what_its_kind_says(effort: str, late: float, delay: float) -> None:
    ratio, tick = 4, 2.5e-4
    ramp = np.arange(4000.0)  # N m a tick; the mean over a tick lies half a tick later
    ticks = np.stack([ramp, ramp, ramp, ramp + 0.5, ramp, 0.0 * ramp], 1)
    chain = Chain(1e-9, 1e-9, 0.5, 0.5, effort, 0.0, delay_samples=delay)
    torque = recorded(ticks, ratio, tick, chain, np.random.default_rng(0)).motor_torque
    samples = np.arange(torque.size, dtype=np.float64)[20:]
    assert np.allclose(torque[20:], ratio * (samples - late - delay))
