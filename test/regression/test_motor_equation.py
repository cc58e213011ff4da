"""Eq. 6 alone gives K whatever moves the link: here another joint that yields, and torque that is recorded late."""

import numpy as np
import pytest
from scipy.signal import lsim, lti

from flex_ident.recording import Floats, Recording
from flex_ident.regression.motor_equation import motor_equation

FINE_HZ, RATE_HZ, DURATION_S = 10000, 500, 24.0
JM, K, FVM, FSM = 1.0, 9000.0, 9.0, 4.5


def played(late_s: float, skew_s: float, seed: int) -> Recording:
    """A motor that sweeps, and a link behind a joint that rings at 6 Hz; torque and link are recorded late."""
    t = np.arange(0.0, DURATION_S, 1.0 / FINE_HZ)
    rng = np.random.default_rng(seed)
    phase = 2.0 * np.pi * 0.3 * DURATION_S / np.log(100.0) * (100.0 ** (t / DURATION_S) - 1.0)
    speed = 0.6 * np.sin(phase) * (1.0 + t) ** -0.3
    position = np.cumsum(speed) / FINE_HZ
    load = 0.6 * np.gradient(speed, 1.0 / FINE_HZ) + 2.0 * speed
    omega, ratio = 2.0 * np.pi * 6.0, 0.03
    rings = lti([omega**2], [1.0, 2.0 * ratio * omega, omega**2])
    deflection = lsim(rings, load, t)[1] / K
    torque = JM * np.gradient(speed, 1.0 / FINE_HZ) + FVM * speed + FSM * np.sign(speed) + K * deflection
    at = np.arange(0.5, DURATION_S - 0.5, 1.0 / RATE_HZ)

    def seen(signal: Floats, late: float) -> Floats:
        return np.asarray(np.interp(at - late, t, signal))

    noise = 0.005 * np.std(torque) * rng.standard_normal(at.size)
    step = 2.0 * np.pi / 2**20
    link = np.round(seen(position - deflection, skew_s) / step) * step
    return Recording("j", float(RATE_HZ), seen(position, 0.0), seen(torque, late_s) + noise, link_position=link)


@pytest.mark.parametrize(
    ("late_s", "skew_s"),
    [(1e-3, 2e-3), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0.0, 0.0), (1e-3, 0.0)))],
)
def test_stiffness_is_right_whatever_moves_the_link_and_however_late_it_is_read(late_s: float, skew_s: float) -> None:
    for seed in range(2):
        found = motor_equation(played(late_s, skew_s, seed))
        assert found.stiffness.identifiable
        assert abs(found.stiffness.value - K) < 4.0 * found.stiffness.std
        assert found.stiffness.std < 3e-3 * K
        assert found.error_percent < 1.2  # of it 0.5 are noise, and the rest reversals between samples
