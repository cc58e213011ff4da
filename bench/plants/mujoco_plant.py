"""The joint in MuJoCo with its own friction loss as it comes: a soft constraint, elastic before it slides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plants.drive import Drive, commanded_torque, start_drive
from plants.laws import Joint, gravity_load

XML = """<mujoco><option timestep="{step}" integrator="implicitfast" gravity="0 0 0"/><worldbody>
<body><joint name="m" type="hinge" axis="0 0 1" damping="{FVm}" frictionloss="{FSm}" armature="{Jm}"/>
<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/></body>
<body><joint name="l" type="hinge" axis="0 0 1" damping="{FV}" frictionloss="{FS}" armature="{JL}"/>
<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
<tendon><fixed name="s" stiffness="{K}"><joint joint="m" coef="1"/><joint joint="l" coef="-1"/></fixed></tendon>
<actuator><motor joint="m"/><motor joint="l"/></actuator></mujoco>"""


def run_mujoco(
    p: Joint, d: Drive, reference: NDArray[np.float64], speed: NDArray[np.float64], acceleration: NDArray[np.float64],
    q0: float,
) -> NDArray[np.float64]:  # fmt: skip
    """What `run_stepping` returns, (n, 6), with steps of 0.25 ms or a whole fraction of a tick below it."""
    import mujoco

    sub = max(1, int(np.ceil(d.tick_s / 2.5e-4 - 1e-9)))
    model = mujoco.MjModel.from_xml_string(XML.format(step=d.tick_s / sub, **p._asdict()))
    data = mujoco.MjData(model)
    hold = gravity_load(p, q0)
    data.qpos[:] = q0 + hold / p.K, q0
    state = start_drive(d, float(data.qpos[0]), hold)
    out = np.zeros((reference.size, 6))
    for k in range(reference.size):
        u = commanded_torque(d, state, float(data.qpos[0]), reference[k], speed[k], acceleration[k])
        out[k] = data.qpos[0], data.qpos[1], u, u, u, data.qvel[0]
        for _ in range(sub):
            data.ctrl[0] = u
            data.ctrl[1] = -gravity_load(p, float(data.qpos[1]))
            mujoco.mj_step(model, data)
    return out
