"""Friction over speed and direction, on inverse dynamics written out here: the bands hold the law behind the torque."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification
from flex_ident.recording import Floats, Recording
from flex_ident.report.figures import embedded
from flex_ident.report.friction import friction_plot, friction_section, law_of
from flex_ident.report.page import Image
from flex_ident.report.result import result_content

RATE_HZ, SECONDS = 200.0, 60.0
J, MX, MY = 2.0, 1.5, -3.0
SEEDS = 5


def law(speed: Floats) -> Floats:
    """Friction, N m: Coulomb, Stribeck and a viscous part that bends, more of it in one direction."""
    size = np.abs(speed)
    viscous = np.where(speed > 0.0, 6.0, 4.0) * size - 0.8 * size**2
    return np.asarray(np.sign(speed) * (5.0 + 2.0 * np.exp(-((size / 0.15) ** 2)) + viscous))


def slow_recording(seed: int) -> Recording:
    """Slow sines over a large range, far below any mode: position with an encoder's steps, torque with noise."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)
    position, speed, acceleration = (np.zeros(time.size) for _ in range(3))
    for hz, size in ((0.07, 0.9), (0.19, 0.35), (0.43, 0.12)):
        phase, w = random.uniform(0.0, 2.0 * np.pi), 2.0 * np.pi * hz
        position += size * np.sin(w * time + phase)
        speed += size * w * np.cos(w * time + phase)
        acceleration -= size * w**2 * np.sin(w * time + phase)
    gravity = 9.81 * (MX * np.cos(position) + MY * np.sin(position))
    torque = J * acceleration + gravity + law(speed) + 0.4 * random.standard_normal(time.size)
    step = 2.0 * np.pi / 2**19
    return Recording("joint", RATE_HZ, np.floor(position / step) * step, torque)


@cache
def identified(seed: int) -> Identification:
    """The first as a user has it; of the others it is said that they are rigid, which is faster."""
    return identify(slow_recording(seed), IdentifyOptions(sensors="motor", rigid=seed > 0))


@pytest.mark.slow
def test_a_slow_recording_has_friction_first_and_no_spring() -> None:
    result = identified(0)
    assert result.model.rigid
    assert result.verdict != "rejected"
    assert result.friction_curve is not None
    assert result.friction_curve.speed.size >= 10


@pytest.mark.campaign
def test_the_bands_hold_the_law() -> None:
    inside, total = 0, 0
    for seed in range(SEEDS):
        curve = identified(seed).friction_curve
        assert curve is not None
        off = curve.friction - law(curve.speed)
        inside += int(np.count_nonzero(np.abs(off) < 1.96 * curve.std))
        total += off.size
        assert float(np.max(np.abs(off))) < 0.3
        assert float(np.median(curve.std)) < 0.15
    assert inside / total > 0.85


@pytest.mark.slow
def test_the_curve_is_in_json_and_in_the_report() -> None:
    recording, result = slow_recording(0), identified(0)
    content = json.loads(json.dumps(result_content(result, recording), allow_nan=False))["friction_curve"]
    assert content["friction_unit"] == "N m"
    assert len(content["speed"]) == len(content["friction"]) == len(content["ci95"][0])
    assert result.friction_curve is not None
    png = friction_plot(result.friction_curve, law_of(result))
    (section,) = friction_section(result, (Image(embedded(png), "friction over speed"),))
    assert len(section.rows) == result.friction_curve.speed.size


@pytest.mark.slow
def test_a_joint_with_a_spring_has_none() -> None:
    assert friction_section(replace(identified(0), friction_curve=None), ()) == []
