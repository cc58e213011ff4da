"""What is estimated beside the joint: bounds, starts, and effects that take a nuisance over."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.effects import CATALOGUE
from flex_ident.likelihood.nuisances import has_own_clock, measurement_priors, model_priors, strained
from flex_ident.likelihood.problem import FitProblem, terms_of
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording, Sampling
from flex_ident.recording.recording import Role
from flex_ident.simulation.terms import MEASUREMENT_KEYS
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

CHAIN = {"torque_delay", "torque_averaging", "effort_lag"}
TURNOVER = {"reversal_speed", "presliding", "reversal_lead"}
STATE = {"initial_deflection", "initial_velocity"}
LINK = {"link_skew", "link_zero", "link_scale", "far_mode"}
KINDS = {
    "rigid": CHAIN | TURNOVER,
    "motor": CHAIN | TURNOVER | STATE,
    "motor+link": CHAIN | TURNOVER | STATE | LINK,
}


@pytest.fixture(scope="module")
def problems() -> dict[str, FitProblem]:
    experiment = Experiment(duration_s=8.0, sample_rate_hz=500.0)
    recording = virtual_recording(COBOT_JOINT, experiment, MeasurementChain(torque_noise=0.01))
    return {
        kind: FitProblem(
            recording, sensors="motor" if kind == "rigid" else kind, rigid=kind == "rigid", band_hz=30.0
        )
        for kind in KINDS
    }  # fmt: skip


@pytest.mark.parametrize("kind", list(KINDS))
def test_each_model_has_its_own(problems: dict[str, FitProblem], kind: str) -> None:
    priors = measurement_priors(problems[kind])
    assert set(priors) == KINDS[kind]
    assert set(priors) <= MEASUREMENT_KEYS
    for key, prior in priors.items():
        assert prior.lower <= prior.start <= prior.upper, key
        assert prior.lower <= prior.mean <= prior.upper, key
        assert 0.0 < prior.std < np.inf, key


def test_a_signal_may_be_late_by_so_many_samples(problems: dict[str, FitProblem]) -> None:
    problem = problems["motor+link"]
    for samples in (1.0, 3.0):
        priors = measurement_priors(problem, late_samples=samples)
        for key in ("torque_delay", "link_skew"):
            assert priors[key].upper == -priors[key].lower == pytest.approx(samples * problem.recording.sample_time)


def test_what_cannot_be_negative_is_not(problems: dict[str, FitProblem]) -> None:
    priors = measurement_priors(problems["motor"])
    for key in ("effort_lag", "reversal_speed", "presliding"):
        assert priors[key].lower == 0.0, key
    assert priors["reversal_lead"].lower == -priors["reversal_lead"].upper


def test_friction_starts_as_a_step_and_can_become_smooth(problems: dict[str, FitProblem]) -> None:
    problem = problems["motor"]
    priors = measurement_priors(problem)
    moving = np.abs(problem.sharp.velocity) > 0.02 * np.std(problem.sharp.velocity)

    def away(values: Values) -> float:
        share, coulomb = (problem.friction_share(terms_of(v, rigid=False)) for v in (values, Values()))
        return float(np.mean(np.abs(share - coulomb)[moving]))

    assert away(Values({key: priors[key].start for key in TURNOVER})) < 0.02
    for key in ("reversal_speed", "presliding"):
        assert away(Values({key: 3.0 * priors[key].std})) > 0.05, key


def test_an_effect_brings_its_own_priors_and_takes_its_nuisance_over(problems: dict[str, FitProblem]) -> None:
    problem = problems["motor+link"]
    plain = set(measurement_priors(problem))
    taken = set()
    for name, effect in CATALOGUE.items():
        priors = model_priors(problem, [name])
        assert plain - set(priors) == {k for k in (effect.replaces, *effect.stand_ins) if k}, name
        own = set(priors) - plain
        assert all(key.startswith(f"{name}.") for key in own), name
        assert bool(own) == (effect.priors is not None), name
        taken |= plain - set(priors)
    chain = {"torque_delay", "effort_lag", "link_skew"}
    assert taken == chain | {"far_mode", "presliding", "reversal_speed", "reversal_lead"}


def sampled(role: Role, topic: str) -> Sampling:
    return Sampling(role, f"{topic}:joint.position", "header", 100, 500.0, 0.0, 0.0, 0.002, 0.0)


def test_a_link_encoder_in_other_messages_may_have_a_clock_of_its_own() -> None:
    still = np.zeros(100)
    apart = (sampled("motor_position", "/joint_states"), sampled("link_position", "/link_joint_states"))
    together = (sampled("motor_position", "/joint_states"), sampled("link_position", "/joint_states"))
    assert has_own_clock(Recording("joint", 500.0, still, still, still, sampling=apart))
    assert not has_own_clock(Recording("joint", 500.0, still, still, still, sampling=together))
    assert not has_own_clock(Recording("joint", 500.0, still, still, still))


def test_friction_that_turns_over_earlier_than_any_is_strained() -> None:
    priors = {"reversal_lead": Prior(0.0, 3e-3, -0.03, 0.03), "torque_delay": Prior(0.0, 1e-3, -3e-3, 3e-3)}
    assert strained(Values({"reversal_lead": 0.02, "torque_delay": 0.0}), priors) == ("reversal_lead",)
    assert strained(Values({"reversal_lead": -0.02, "torque_delay": 0.0}), priors) == ("reversal_lead",)
    assert strained(Values({"reversal_lead": 0.004, "torque_delay": 0.0}), priors) == ()


@pytest.mark.parametrize("turns", [-3000.0, 0.0, 50.0])
def test_encoders_may_count_from_any_zeros(turns: float) -> None:
    experiment = Experiment(duration_s=8.0, sample_rate_hz=500.0)
    recording = virtual_recording(COBOT_JOINT, experiment, MeasurementChain(torque_noise=0.01))
    assert recording.link_position is not None
    off = 2.0 * np.pi * turns - 1.0
    moved = replace(recording, link_position=recording.link_position + off)
    zero = measurement_priors(FitProblem(moved, sensors="motor+link", band_hz=30.0))["link_zero"]
    assert zero.start == pytest.approx(off, abs=1e-3)
    assert zero.lower < off < zero.upper
