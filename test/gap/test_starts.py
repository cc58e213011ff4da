"""Where a fit with one effect starts when the fit without it is lost.

The truth is the virtual joint, which is no model of ours.
"""

import pytest

from flex_ident.effects.backlash import dead_band_start
from flex_ident.effects.time_delay import delay_scanned_start
from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import explain
from flex_ident.parameters.values import Values
from flex_ident.screening.anew import FitScans
from flex_ident.screening.candidates import scales_of
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=24.0, sample_rate_hz=500.0)
CHAIN = MeasurementChain(torque_noise=0.01, jitter=0.02)


def recorded(joint: str, effect: str, *, link: bool, **parameters: float):
    return virtual_recording(JOINTS[joint].with_effect(effect, parameters), EXPERIMENT, CHAIN, seed=5, link=link)


def scans(joint: str, effect: str, *, link: bool, **parameters: float) -> FitScans:
    """What an effect is given to find its start with, where the model is right but for the effect."""
    recording = recorded(joint, effect, link=link, **parameters)
    problem = fit_problem(recording, sensors="motor+link" if link else "motor")
    values = Values(JOINTS[joint].parameters)
    return FitScans(problem, values, scales_of(problem, values))


@pytest.mark.parametrize("delay", [-8e-3, 8e-3])
def test_a_delay_of_several_samples_is_scanned_together_with_the_mode(delay: float) -> None:
    found = delay_scanned_start(scans("paper", "time_delay", link=False, delay=delay))
    assert found.effect["delay"] == pytest.approx(delay, abs=1.5e-3)
    assert found.model["Jm"] == pytest.approx(JOINTS["paper"].value("Jm"), rel=0.1)


@pytest.mark.campaign
def test_a_delay_in_which_the_base_fit_is_lost_is_named_and_measured() -> None:
    found = explain(recorded("paper", "time_delay", link=False, delay=0.0115))
    assert [f.effect for f in found.findings] == ["time_delay"]
    (delay,) = found.findings[0].parameters
    assert abs(delay.value - 0.0115) < 4.0 * delay.std < 2e-3
    # A low-pass in the effort is late by its time constant: high frequencies alone tell the two apart.
    lag = next(p.value for p in found.final.measurement if p.key == "effort_lag")
    assert delay.value + lag == pytest.approx(0.0115, abs=1e-4)
    assert found.final.parameter("K").value == pytest.approx(JOINTS["paper"].value("K"), rel=0.02)


@pytest.mark.parametrize(("joint", "gap"), [("paper", 1e-2), ("cobot", 6e-4), ("series_elastic", 3e-3)])
def test_a_dead_band_is_seen_where_both_positions_are_measured(joint: str, gap: float) -> None:
    found = dead_band_start(scans(joint, "backlash", link=True, gap=gap))
    assert found is not None
    assert found.effect["gap"] == pytest.approx(gap, rel=0.05)
    for key in ("Jm", "K", "JL"):
        assert found.model[key] == pytest.approx(JOINTS[joint].value(key), rel=0.03), key


def test_without_a_link_encoder_there_is_no_dead_band_to_see() -> None:
    assert dead_band_start(scans("cobot", "backlash", link=False, gap=6e-4)) is None
