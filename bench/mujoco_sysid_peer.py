"""The same recordings through MuJoCo's own identification toolbox: python bench/mujoco_sysid_peer.py --draws 3

The peer gets what an expert would give it. Its model is two hinges about one axis and a tendon that is the spring,
with the right structure. The recorded torque drives it, a stiff feedback keeps it on the recorded motor position, and
what the feedback must add is the residual: no controller need be known. With a link encoder its position is a second
residual, weighted by noise levels that the peer is told. It starts `--guess` off the truth; flex_ident gets no start.
Both see the virtual joint's recordings, whose physics belong to neither. Needs `pip install "mujoco[sysid]"`.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.filtering.derivatives import zero_phase_lowpass
from flex_ident.parameters import JointModel
from flex_ident.recording import Recording
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

try:
    import mujoco
    from mujoco import sysid
except ImportError:
    raise SystemExit('mujoco.sysid is missing: pip install "mujoco[sysid]" (a bench extra only).') from None

KEYS = ("Jm", "K", "JL")
MASS = 1e6
"""Of the link, kg: its centre then lies so near to the axis that it adds nothing to JL."""
TORQUE_NOISE, LINK_NOISE = 0.01, 2e-6
"""Relative torque noise and the link encoder's noise, rad, of the recordings; the peer is told both."""
FEEDBACK_HZ = 60.0
XML = """
<mujoco><option timestep="{step}" gravity="0 0 -9.81" integrator="Euler"><flag contact="disable"/></option>
<worldbody>
<body><inertial pos="0 0 0" mass="1" diaginertia="1e-6 1e-6 1e-6"/><joint name="motor" axis="0 1 0"
solreffriction="{soft} 1" solimpfriction="0.999 0.9999 0.001"/></body>
<body name="link"><inertial pos="0 0 0" mass="{mass}" diaginertia="1e-6 1e-6 1e-6"/><joint name="link" axis="0 1 0"
solreffriction="{soft} 1" solimpfriction="0.999 0.9999 0.001"/></body>
</worldbody>
<tendon><fixed name="spring"><joint joint="motor" coef="1"/><joint joint="link" coef="-1"/></fixed></tendon>
<actuator><position name="stay" joint="motor" kp="{kp}"/><velocity name="calm" joint="motor" kv="{kv}"/>
<motor name="torque" joint="motor"/></actuator>
<sensor><jointactuatorfrc name="motor torque" joint="motor"/>{link}</sensor></mujoco>"""


@dataclass(frozen=True)
class Answer:
    """Value and half of the 95 % interval of each key, and the time it took, s."""

    found: dict[str, tuple[float, float]]
    seconds: float


def setters() -> dict[str, Callable[[Any, float], None]]:
    """How each parameter is written into MuJoCo's description."""

    def of(part: str, name: str, attribute: str) -> Callable[[Any, float], None]:
        return lambda spec, value: setattr(getattr(spec, part)(name), attribute, value)

    def centre(axis: int) -> Callable[[Any, float], None]:
        def put(spec: Any, value: float) -> None:
            position = np.array(spec.body("link").ipos)
            position[axis] = -value / MASS
            spec.body("link").ipos = position

        return put

    def stiffness(spec: Any, value: float) -> None:
        spec.tendon("spring").stiffness = np.array([value, 0.0, 0.0])

    def damping(name: str) -> Callable[[Any, float], None]:
        def put(spec: Any, value: float) -> None:
            spec.joint(name).damping = np.array([value, 0.0, 0.0])

        return put

    return {
        "Jm": of("joint", "motor", "armature"), "JL": of("joint", "link", "armature"), "K": stiffness,
        "FVm": damping("motor"), "FV": damping("link"), "FSm": of("joint", "motor", "frictionloss"),
        "FS": of("joint", "link", "frictionloss"), "MX": centre(0), "MY": centre(2),
    }  # fmt: skip


def by_toolbox(recording: Recording, model: JointModel, sensors: str, step: float, guess: float) -> Answer:
    """The toolbox's least squares, from `guess` off the truth."""
    start = time.perf_counter()
    w = 2.0 * np.pi * FEEDBACK_HZ
    link = '<jointpos name="link position" joint="link"/>' if sensors == "motor+link" else ""
    inertia = model.value("Jm")
    spec = mujoco.MjSpec.from_string(
        XML.format(step=step, soft=2.0 * step, mass=MASS, kp=inertia * w * w, kv=2.0 * inertia * w, link=link)
    )
    parameters = sysid.ParameterDict()
    for i, (key, put) in enumerate(setters().items()):
        first = model.value(key) * guess ** (1 if i % 2 else -1)
        low, high = sorted((first / 10.0, first * 10.0))
        parameters.add(
            sysid.Parameter(
                key, 1.0, low / first if first > 0 else high / first, high / first if first > 0 else low / first,
                modifier=lambda spec, p, put=put, first=first: put(spec, first * float(p.value.item())),
            )
        )  # fmt: skip
    compiled = sysid.apply_param_modifiers(parameters, spec)
    dt = recording.sample_time
    position, torque = recording.motor_position, recording.motor_torque
    times = np.arange(position.size) * dt
    velocity = np.gradient(zero_phase_lowpass(position, w, 4, 1.0 / dt), dt)
    control = sysid.TimeSeries.from_control_names(times, np.column_stack([position, velocity, torque]), compiled)
    seen = [torque] if not link else [torque, recording.link_position]
    sensed = sysid.TimeSeries.from_names(times, np.column_stack(seen), compiled)
    link_start = recording.link_position[0] if link and recording.link_position is not None else position[0]
    state = sysid.create_initial_state(compiled, np.array([position[0], link_start]), np.zeros(2))
    weights = {"motor torque": 1.0 / TORQUE_NOISE}
    if link:
        assert recording.link_position is not None
        weights["link position"] = float(np.std(recording.link_position)) / LINK_NOISE
    residual = sysid.build_residual_fn(
        models_sequences=[
            sysid.ModelSequences("joint", spec, "run", state, control, sensed, allow_missing_sensors=False)
        ],
        sensor_weights=weights,
    )  # fmt: skip
    solved, result = sysid.optimize(parameters, residual, optimizer="mujoco", verbose=False)
    ends = residual(result.x, solved)[0]
    half = sysid.calculate_intervals(ends, np.asarray(result.jac))[1]
    scale = [model.value(k) * guess ** (1 if i % 2 else -1) for i, k in enumerate(setters())]
    found = {
        key: (float(value * s), float(h * abs(s)))
        for key, value, h, s in zip(setters(), result.x, half, scale, strict=True)
    }
    return Answer(found, time.perf_counter() - start)


def stable_by_toolbox(
    recording: Recording, model: JointModel, sensors: str, step: float, guess: float
) -> Answer | None:
    """The toolbox's answer, its step halved up to twice when a simulation runs away; None when all do."""
    start = time.perf_counter()
    for smaller in (step, step / 2.0, step / 4.0):
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                answer = by_toolbox(recording, model, sensors, smaller, guess)
        except ValueError:  # what the toolbox makes of a simulation that MuJoCo reset
            continue
        return Answer(answer.found, time.perf_counter() - start)
    return None


def by_flex_ident(recording: Recording, sensors: str) -> Answer:
    """`identify` as the command does it, without a start."""
    start = time.perf_counter()
    result = identify(recording, IdentifyOptions(sensors=sensors))
    found = {k: (result.parameter(k).value, 1.96 * result.parameter(k).std) for k in KEYS}
    return Answer(found, time.perf_counter() - start)


def main() -> None:
    """A row for each joint, sensors and tool."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--joints", default="paper,cobot,series_elastic")
    parser.add_argument("--sensors", default="motor,motor+link")
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--guess", type=float, default=1.3)
    parser.add_argument("--step", type=float, default=5e-4, help="the peer's integration step, s")
    given = parser.parse_args()
    print(f"Peer's step {1e3 * given.step:g} ms, start a factor of {given.guess:g} off.\n")
    print("| joint | sensors | tool | Jm % | K % | JL % | truth inside ±95 % | seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    chain = MeasurementChain.with_bits(20, 20, torque_noise=TORQUE_NOISE, jitter=0.05, lost=0.002)
    for joint in given.joints.split(","):
        model = JOINTS[joint]
        recordings = [
            virtual_recording(model, Experiment(duration_s=given.duration), chain, seed=700 + i)
            for i in range(given.draws)
        ]
        for sensors in given.sensors.split(","):
            answers: dict[str, list[Answer]] = {"flex_ident": [], "mujoco.sysid": []}
            for recording in recordings:
                try:
                    answers["flex_ident"].append(by_flex_ident(recording, sensors))
                except FlexIdentError as error:
                    print(f"{joint} {sensors}: {error}")
                theirs = stable_by_toolbox(recording, model, sensors, given.step, given.guess)
                if theirs is not None:
                    answers["mujoco.sysid"].append(theirs)
            for tool, some in answers.items():
                print(row(joint, sensors, tool, model, some, given.draws), flush=True)


def row(joint: str, sensors: str, tool: str, model: JointModel, answers: list[Answer], asked: int) -> str:
    """Errors as mean ± spread, %."""
    if not answers:
        return f"| {joint} | {sensors} | {tool} | {asked} of {asked} failed | | | | |"
    cells = []
    inside = total = 0
    for key in KEYS:
        true = model.value(key)
        errors = [100.0 * (a.found[key][0] / true - 1.0) for a in answers]
        cells.append(f"{np.mean(errors):+.2f} ± {np.std(errors):.2f}")
        inside += sum(abs(a.found[key][0] - true) <= a.found[key][1] for a in answers)
        total += len(answers)
    seconds = statistics.median(a.seconds for a in answers)
    return f"| {joint} | {sensors} | {tool} | " + " | ".join(cells) + f" | {inside} of {total} | {seconds:.1f} |"


if __name__ == "__main__":
    main()
