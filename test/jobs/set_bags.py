"""Bags of one rigid joint, computed here and not by the project: friction that is not linear, ripple, another size."""

from pathlib import Path

import numpy as np

from flex_ident.bags import writing


def joint_bag(
    path: Path, *, seed: int, quadratic: float = 0.0, ripple: float = 0.0, zero: float = 0.0, inertia: float = 2.0,
    amplitude: float = 0.3, scale: float = 1.0,
) -> Path:  # fmt: skip
    """A joint of J 2, FV 3, FS 1 under a chirp; `quadratic`, N m s^2/rad^2, times v abs(v); `ripple`, N m, 40 times a
    turn, from a position `zero`, rad; the torque as recorded `scale` times that, and noise."""
    t = np.arange(0.0, 20.0, 1.0 / 400.0)
    phase, omega = 2 * np.pi * (0.2 * t + 0.08 * t**2), 2 * np.pi * (0.2 + 0.16 * t)
    q, v = amplitude * np.sin(phase), amplitude * omega * np.cos(phase)
    a = amplitude * (2 * np.pi * 0.16 * np.cos(phase) - omega**2 * np.sin(phase))
    torque = inertia * a + 3.0 * v + np.sign(v) + quadratic * v * np.abs(v) + ripple * np.sin(40.0 * (q + zero) + 0.3)
    torque = scale * torque + np.random.default_rng(seed).normal(0.0, 0.3, t.size)
    writing.write_joint_states(path, t, ["elbow"], q[:, None], v[:, None], torque[:, None])
    return path
