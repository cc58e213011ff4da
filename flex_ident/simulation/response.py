"""What the encoders and the drive would have recorded, were the joint made of the given terms: eqs. 5 and 6."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.batch import LANES, side_by_side, simulated_alone, simulated_links
from flex_ident.simulation.bristles import bristle_torque
from flex_ident.simulation.compiled import COMPILED
from flex_ident.simulation.curves import curve, one_for_each_direction
from flex_ident.simulation.encoder_error import behind_encoder
from flex_ident.simulation.harmonics import periodic, periodic_slope, transmission_error
from flex_ident.simulation.kernel import simulated_link
from flex_ident.simulation.motion import MotorMotion
from flex_ident.simulation.mount import simulated_link_on_mount
from flex_ident.simulation.terms import ANGLE_CURVE, FRICTION_CURVE, FRICTION_WAVES, KINEMATIC_ERRORS, RIPPLES, Term


@dataclass(frozen=True)
class Response:
    """Simulated `motor_torque`, `spring_torque` (N m), `link_position` (rad) and `link_velocity`, each (n,).

    NaN from where the simulation ran away. A rigid joint has no spring torque and the motor's position as link's.
    """

    motor_torque: Floats
    spring_torque: Floats
    link_position: Floats
    link_velocity: Floats


def direction(motion: MotorMotion, resolution: float = 0.0) -> Floats:
    """Sign of the motor velocity (n,), averaged over the sample it stands for, so that reversals do not alias.

    `resolution`, rad/s, is the velocity below which the recording cannot tell the direction.
    """
    width = np.maximum(0.5 * np.abs(motion.acceleration) * motion.sample_time, max(resolution, 1e-12))
    sign: Floats = np.clip(motion.velocity / width, -1.0, 1.0)
    return sign


@dataclass(frozen=True)
class LinkMotion:
    """The link as simulated, each (n,): torque through the spring, N m, position, rad, velocity, rad/s.

    `swing`, rad/s^2: the acceleration of the base that all is relative to; None where it does not give way.
    """

    spring_torque: Floats
    position: Floats
    velocity: Floats
    swing: Floats | None = None


def link_motion(terms: Floats, motion: MotorMotion) -> LinkMotion:
    """The link driven through the spring by the motor's motion (eq. 5), at the recording's samples."""
    if not (COMPILED and side_by_side(terms)):
        return stepped_link_motion(terms, motion)
    n, s = (motion.fine_position.size + 1) // 2, motion.substeps
    torque, position, velocity = (np.empty((1, n)) for _ in range(3))
    simulated_alone(
        terms[None], motion.fine_position, motion.fine_velocity, motion.step, torque, position, velocity
    )  # fmt: skip
    return LinkMotion(torque[0, ::s], position[0, ::s], velocity[0, ::s])


def stepped_link_motion(terms: Floats, motion: MotorMotion) -> LinkMotion:
    """The same by steps that know every term; what the quicker ways are compared with."""
    motion = behind_encoder(terms, motion)
    base, rate = motion.fine_position, motion.fine_velocity
    if transmission_error(terms):
        rate = rate * (1.0 + periodic_slope(terms, KINEMATIC_ERRORS, base))
        base = base + periodic(terms, KINEMATIC_ERRORS, base)
    n = (base.size + 1) // 2
    torque, position, velocity = np.empty(n), np.empty(n), np.empty(n)
    s = motion.substeps
    if terms[Term.MOUNT_INERTIA] > 0.0:
        swing = np.empty(n)
        simulated_link_on_mount(terms, base, rate, motion.step, torque, position, velocity, swing)
        return LinkMotion(torque[::s], position[::s], velocity[::s], swing[::s])
    simulated_link(terms, base, rate, motion.step, torque, position, velocity)
    return LinkMotion(torque[::s], position[::s], velocity[::s])


def link_motions(many: Sequence[Floats], motion: MotorMotion) -> list[LinkMotion]:
    """The same under each of several sets of terms, side by side where they can be."""
    together = [i for i, terms in enumerate(many) if COMPILED and side_by_side(terms)]
    found: dict[int, LinkMotion] = {}
    n, s = (motion.fine_position.size + 1) // 2, motion.substeps
    for first in range(0, len(together), LANES):
        lanes = together[first : first + LANES]
        if len(lanes) == 1:
            continue
        terms = np.array([many[lanes[min(j, len(lanes) - 1)]] for j in range(LANES)])
        torque, position, velocity = (np.empty((LANES, n)) for _ in range(3))
        simulated_links(terms, motion.fine_position, motion.fine_velocity, motion.step, torque, position, velocity)
        for j, i in enumerate(lanes):
            found[i] = LinkMotion(torque[j, ::s], position[j, ::s], velocity[j, ::s])
    return [found[i] if i in found else link_motion(terms, motion) for i, terms in enumerate(many)]


def standstill_friction(terms: Floats) -> float:
    """Size of the motor's dry friction at standstill, N m, not under load."""
    return float(terms[Term.MOTOR_COULOMB] + terms[Term.MOTOR_STRIBECK] + terms[Term.BRISTLE_STRIBECK])


def motor_friction(terms: Floats, motion: MotorMotion, spring_torque: Floats, sign: Floats) -> Floats:
    """Friction on the motor's side (n,), N m: eq. 4 and the effects that add to it."""
    v = motion.velocity
    coulomb = terms[Term.MOTOR_COULOMB] + terms[Term.MOTOR_LOAD_FRICTION] * np.abs(spring_torque)
    if terms[Term.MOTOR_STRIBECK] != 0.0 and terms[Term.MOTOR_STRIBECK_VELOCITY] > 0.0:
        coulomb = coulomb + terms[Term.MOTOR_STRIBECK] * np.exp(-((v / terms[Term.MOTOR_STRIBECK_VELOCITY]) ** 2))
    if terms[Term.BRISTLE_STRIBECK] != 0.0 and terms[Term.BRISTLE_STRIBECK_VELOCITY] > 0.0:
        coulomb = coulomb + terms[Term.BRISTLE_STRIBECK] * np.exp(-((v / terms[Term.BRISTLE_STRIBECK_VELOCITY]) ** 2))
    if any(terms[size] != 0.0 for size, *_ in FRICTION_WAVES):
        coulomb = coulomb + periodic(terms, FRICTION_WAVES, motion.position)
    dry = coulomb * sign
    if terms[Term.BRISTLE_DEFLECTION] > 0.0:
        stiffness = standstill_friction(terms) / terms[Term.BRISTLE_DEFLECTION]
        level = np.broadcast_to(coulomb, v.shape)
        dry = bristle_torque(sign, np.ascontiguousarray(level), motion.position, float(stiffness))
    elif terms[Term.SOFT_FRICTION] > 0.0:
        stopping = motion.acceleration + v / terms[Term.SOFT_FRICTION_TIME]
        dry = np.clip(terms[Term.MOTOR_INERTIA] / terms[Term.SOFT_FRICTION] * stopping, -coulomb, coulomb)
    viscous = terms[Term.MOTOR_VISCOUS] * v
    viscous = viscous + terms[Term.MOTOR_VISCOUS_ASYMMETRY] * np.abs(v)
    viscous = viscous + terms[Term.MOTOR_VISCOUS_QUADRATIC] * v * np.abs(v)
    if terms[FRICTION_CURVE.points] > 0.0:
        viscous = viscous + one_for_each_direction(*FRICTION_CURVE.of(terms), v, sign)
    rate = terms[Term.FRICTION_RATE] + terms[Term.MOTOR_FRICTION_RATE]
    friction: Floats = (viscous + dry) * (1.0 + rate * motion.sample_time * np.arange(v.size))
    return friction


def motor_torque(terms: Floats, motion: MotorMotion, link: LinkMotion | None, sign: Floats) -> Floats:
    """Torque the motor must deliver for its recorded motion (n,), N m: eq. 6. Without `link`, of a rigid joint."""
    motion = behind_encoder(terms, motion)
    if link is not None:
        load = link.spring_torque
    else:
        load = terms[Term.GRAVITY_COS] * np.cos(motion.position) + terms[Term.GRAVITY_SIN] * np.sin(motion.position)
        load = load + terms[Term.CABLE_STIFFNESS] * motion.position + terms[Term.CABLE_TORQUE]
        if terms[Term.CABLE_COS_2] != 0.0 or terms[Term.CABLE_SIN_2] != 0.0:
            twice = 2.0 * motion.position
            load = load + terms[Term.CABLE_COS_2] * np.cos(twice) + terms[Term.CABLE_SIN_2] * np.sin(twice)
    reaction = load
    if link is not None and transmission_error(terms):  # virtual work: a ratio that varies loads the motor so
        reaction = load * (1.0 + periodic_slope(terms, KINEMATIC_ERRORS, motion.position))
    acceleration = motion.acceleration
    if link is not None and link.swing is not None:
        acceleration = acceleration + link.swing
    torque = terms[Term.MOTOR_INERTIA] * acceleration + reaction + terms[Term.OFFSET]
    torque = torque + motor_friction(terms, motion, load, sign)
    if terms[Term.GRAVITY_REMOVED] != 0.0:
        weight = terms[Term.GRAVITY_COS] * np.cos(motion.position) + terms[Term.GRAVITY_SIN] * np.sin(motion.position)
        torque = torque - terms[Term.GRAVITY_REMOVED] * weight
    if terms[Term.FRICTION_REMOVED] != 0.0 and terms[Term.FRICTION_REMOVED_SPEED] > 0.0:
        added = np.tanh(motion.velocity / terms[Term.FRICTION_REMOVED_SPEED])
        torque = torque + terms[Term.FRICTION_REMOVED] * (sign - added)
    if any(terms[size] != 0.0 for size, *_ in RIPPLES):
        torque = torque + periodic(terms, RIPPLES, motion.position)
    if terms[ANGLE_CURVE.points] > 0.0:
        torque = torque + curve(*ANGLE_CURVE.of(terms), motion.position)
    result: Floats = torque
    return result


def simulated_response(terms: Floats, motion: MotorMotion, *, rigid: bool = False, resolution: float = 0.0) -> Response:
    """The joint of `terms` moved along `motion`; nothing of the measurement chain applied (delay, zero, skew)."""
    sign = direction(motion, resolution)
    if rigid:
        torque = motor_torque(terms, motion, None, sign)
        return Response(torque, np.zeros_like(torque), motion.position, motion.velocity)
    link = link_motion(terms, motion)
    return Response(motor_torque(terms, motion, link, sign), link.spring_torque, link.position, link.velocity)
