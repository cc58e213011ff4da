"""`flex_ident export`: a result in the words of other tools."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from pathlib import Path
from xml.sax.saxutils import quoteattr

import yaml

from flex_ident.commands.formats import FORMATS
from flex_ident.commands.results import StoredResult, stored_result
from flex_ident.effects import parameter_named
from flex_ident.errors import ConfigurationError, DataError, UsageError
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.parameters.keys import effect_in
from flex_ident.simulation.terms import GRAVITY, Term

ROTOR_SHARE = 1e-6
"""Inertia of the rotor's body over its armature: MuJoCo wants a mass and an inertia of every body that moves."""
STEPS_PER_PERIOD = 40.0
"""Time steps in a period of the free resonance."""
LONGEST_STEP_S = 1e-3
GRAVITY_TERMS = (Term.GRAVITY_COS, Term.GRAVITY_SIN)
TENDON_TERMS = (Term.HALF_GAP, Term.SPRING_DAMPING)
"""Terms of effects that the MuJoCo model holds; others are named as left out."""


def exported(path: Path, to: str) -> str:
    """The result in `path` as text in one of FORMATS. Raises UsageError and DataError; a rejected result is refused."""
    writers: dict[str, Callable[[StoredResult], str]] = {
        "urdf": _urdf, "mujoco": _mujoco, "yaml": _yaml, "csv": _csv,
    }  # fmt: skip
    if to not in writers:
        raise UsageError(f"--to is '{to}': expected one of {', '.join(FORMATS)}.")
    result = stored_result(path)
    if result.verdict == "rejected":
        raise DataError(_refusal(result))
    return writers[to](result)


def _refusal(result: StoredResult) -> str:
    """Why a rejected result is not exported: the verdict and what spoke against it."""
    weak = [p.key for p in result.parameters if not p.identifiable]
    undetermined = f"not determined: {', '.join(weak)}" if weak else ""
    unsaid = ("not_identifiable", "motor_equation")
    try:
        warnings = json.loads(result.path.read_text(encoding="utf-8")).get("warnings", [])
        said = [str(w["message"]).split(": run explain_gap")[0] for w in warnings if w["code"] not in unsaid]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        said = []
    why = "; ".join(text.rstrip(".") for text in (undetermined, *said[:1]) if text)
    return (
        f"{result.path}: {result.joint} was rejected{': ' + why if why else ''}. Nothing is exported: the numbers must "
        "not be used. Identify from a recording that gives a better verdict."
    )


def _number(result: StoredResult, key: str, *, lowest: float = -math.inf) -> float:
    """A parameter's value, at least `lowest`; 0 when the result does not hold it as a number."""
    value = result.value(key)
    return max(lowest, value) if math.isfinite(value) else 0.0


def _positive(result: StoredResult, key: str) -> float:
    """An inertia or a stiffness. Raises DataError when it is none."""
    value = result.value(key)
    if not (math.isfinite(value) and value > 0.0):
        raise DataError(f"{result.path}: {key} is {value:.4g}: it must be positive to be exported.")
    return value


def _term_of(key: str) -> Term | None:
    """The term that an effect's parameter adds to; None for a base parameter and for an effect that is none."""
    try:
        return None if effect_in(key) is None else parameter_named(key).term
    except (ConfigurationError, KeyError):
        return None


def _from_effects(result: StoredResult, term: Term, *, lowest: float = -math.inf) -> float:
    """What the result's effects add to a term, each parameter at least `lowest`."""
    keys = [p.key for p in result.parameters if _term_of(p.key) == term]
    return math.fsum(parameter_named(key).factor * _number(result, key, lowest=lowest) for key in keys)


def _has(result: StoredResult, key: str) -> bool:
    return any(p.key == key for p in result.parameters)


def _is_rigid(result: StoredResult) -> bool:
    return _has(result, "J")


def _remarks(result: StoredResult, *texts: str, held: tuple[Term, ...] = ()) -> str:
    """An XML comment: the verdict, what the recording does not determine, the texts, the effects left out."""
    weak = [p.key for p in result.parameters if not p.identifiable]
    effects = [p.key for p in result.parameters if effect_in(p.key) is not None and _term_of(p.key) not in held]
    lines = [
        f"{result.joint}: {result.verdict}, from {result.path.name} of flex_ident.",
        *([f"Not determined by the recording, do not rely on: {', '.join(weak)}."] if weak else []),
        *([f"Left out, there being no such thing here: {', '.join(effects)}."] if effects else []),
        *texts,
    ]
    return "<!-- " + "\n     ".join(lines).replace("--", "- -") + " -->"


def _urdf(result: StoredResult) -> str:
    """URDF has no elastic joint: friction as joint dynamics, the rotor as transmissions have it."""
    rigid = _is_rigid(result)
    viscous = sum(_number(result, k, lowest=0.0) for k in ("FVm", "FV"))
    dry = sum(_number(result, k, lowest=0.0) for k in ("FSm", "FS"))
    name = quoteattr(result.joint)
    joint = (
        f"<joint name={name}>\n"
        f'  <dynamics damping="{viscous:.6g}" friction="{dry:.6g}"/>\n'
        f"</joint>"
    )  # fmt: skip
    merge = "Put the <dynamics> into the robot's own <joint>."
    if rigid:
        text = (
            f"J = {_positive(result, 'J'):.6g} {_unit(result, 'J')}, motor and link together about the joint's axis, "
            "is left out: URDF keeps inertia in the <inertial> of links."
        )
        return f"{_remarks(result, text, merge)}\n{joint}"
    text = (
        f"URDF has no spring: K = {_positive(result, 'K'):.6g} {_unit(result, 'K')} is left out, and friction of "
        f"motor and link is one. JL = {_positive(result, 'JL'):.6g} {_unit(result, 'JL')} about the joint's axis is "
        "left out: URDF keeps inertia in the <inertial> of links. motorInertia is on the link side of the gear."
    )
    return (
        f"{_remarks(result, text, merge)}\n{joint}\n"
        f"<transmission name={quoteattr(result.joint + '_transmission')}>\n"
        f"  <type>transmission_interface/SimpleTransmission</type>\n"
        f"  <joint name={name}/>\n"
        f"  <actuator name={quoteattr(result.joint + '_motor')}>\n"
        f"    <mechanicalReduction>1</mechanicalReduction>\n"
        f"    <motorInertia>{_positive(result, 'Jm'):.6g}</motorInertia>\n"
        f"  </actuator>\n"
        f"</transmission>"
    )


def _unit(result: StoredResult, key: str) -> str:
    return next((p.unit for p in result.parameters if p.key == key), "")


def _mujoco(result: StoredResult) -> str:
    """A whole MuJoCo model: link and rotor about one axis, each with its friction, a tendon between them as the spring.

    Both hang from the base, so that each one's friction acts against it as in eqs. 5 and 6; the actuator takes the
    motor's torque on the link side of the gear. A rigid joint is one body.
    """
    rigid = _is_rigid(result)
    step = LONGEST_STEP_S if rigid else min(LONGEST_STEP_S, 1.0 / (STEPS_PER_PERIOD * _free_resonance_hz(result)))
    step = float(f"{step:.1e}")
    link, motor = result.joint, result.joint if rigid else f"{result.joint}_motor"
    inertia = _positive(result, "J" if rigid else "JL")
    bodies = _link_body(result, link, inertia, step)
    tendon = ""
    texts = [
        "The axis is horizontal and the zero position that of the recording: link weight is MX g cos q + MY g sin q.",
        "Only inertia about the axis and first moments were identified: mass and place of the centre of mass go with "
        "them, but stand for no others.",
    ]
    if _slides(result):
        texts = ["The axis is horizontal: what gravity does along it is in the motor's constant force."]
    if not rigid:
        bodies += _rotor_body(result, motor, step)
        tendon = _spring(result, link, motor)
        texts.append(f"{motor} is the rotor on the link side of the gear, and the tendon the joint's spring.")
    offset = _number(result, "offset")
    constant = f' biastype="affine" biasprm="{-offset:.9g} 0 0"' if offset else ""
    held = GRAVITY_TERMS if rigid else (*GRAVITY_TERMS, *TENDON_TERMS)
    return (
        f"{_remarks(result, *texts, held=held)}\n"
        f"<mujoco model={quoteattr(result.joint)}>\n"
        f'  <compiler angle="radian"/>\n'
        f'  <option timestep="{step:.6g}" gravity="0 0 -{GRAVITY}" integrator="implicitfast"/>\n'
        f"  <worldbody>\n{bodies}  </worldbody>\n{tendon}"
        f"  <actuator>\n"
        f"    <general name={quoteattr(motor)} joint={quoteattr(motor)}{constant}/>\n"
        f"  </actuator>\n"
        f"</mujoco>"
    )


def _slides(result: StoredResult) -> bool:
    """Whether the joint is prismatic: its inertia is a mass."""
    return _unit(result, "J" if _is_rigid(result) else "Jm") == "kg"


def _free_resonance_hz(result: StoredResult) -> float:
    compliance = 1.0 / _positive(result, "Jm") + 1.0 / _positive(result, "JL")
    return math.sqrt(_positive(result, "K") * compliance) / (2.0 * math.pi)


def _joint_element(name: str, kind: str, viscous: float, dry: float, step: float, armature: float = 0.0) -> str:
    """A joint; dry friction as stiff a constraint as the time step allows."""
    rotor = f' armature="{armature:.9g}"' if armature else ""
    friction = f' frictionloss="{dry:.9g}" solreffriction="{2.0 * step:.6g} 1"' if dry else ""
    return f'<joint name={quoteattr(name)} {kind}{rotor} damping="{viscous:.9g}"{friction}/>'


def _link_body(result: StoredResult, name: str, inertia: float, step: float) -> str:
    """The link: `inertia` about the axis, and a centre of mass that gives MX and MY.

    The mass is not identified: it is what leaves half of the inertia to the centre of mass's own.
    """
    viscous, dry = (_number(result, k, lowest=0.0) for k in ("FV", "FS"))
    kind, mass, own, place = 'type="hinge" axis="0 1 0"', 1.0, inertia, (0.0, 0.0)
    if _slides(result):
        kind, mass = 'type="slide" axis="1 0 0"', inertia
    else:
        mx, my = (
            _number(result, k) + _from_effects(result, t) / GRAVITY
            for k, t in zip(GRAVITY_KEYS, GRAVITY_TERMS, strict=True)
        )
        moment = math.hypot(mx, my)
        if moment > 0.0:
            mass = 2.0 * moment**2 / inertia
            own, place = 0.5 * inertia, (-mx / mass, -my / mass)
    joint = _joint_element(name, kind, viscous, dry, step)
    return (
        f"    <body name={quoteattr(name + '_link')}>\n"
        f'      <inertial pos="{place[0]:.9g} 0 {place[1]:.9g}" mass="{mass:.9g}" '
        f'diaginertia="{own:.9g} {own:.9g} {own:.9g}"/>\n'
        f"      {joint}\n"
        f"    </body>\n"
    )


def _rotor_body(result: StoredResult, name: str, step: float) -> str:
    """The rotor: its inertia is the joint's armature, the body is there because MuJoCo wants one."""
    inertia = _positive(result, "Jm")
    small = ROTOR_SHARE * inertia
    kind = 'type="slide" axis="1 0 0"' if _slides(result) else 'type="hinge" axis="0 1 0"'
    viscous, dry = (_number(result, k, lowest=0.0) for k in ("FVm", "FSm"))
    joint = _joint_element(name, kind, viscous, dry, step, armature=inertia)
    return (
        f"    <body name={quoteattr(name)}>\n"
        f'      <inertial pos="0 0 0" mass="{small:.9g}" diaginertia="{small:.9g} {small:.9g} {small:.9g}"/>\n'
        f"      {joint}\n"
        f"    </body>\n"
    )


def _spring(result: StoredResult, link: str, motor: str) -> str:
    """The spring as a fixed tendon from link to rotor; its dead band is the backlash."""
    half = _from_effects(result, Term.HALF_GAP, lowest=0.0)
    damping = _from_effects(result, Term.SPRING_DAMPING, lowest=0.0)
    return (
        f"  <tendon>\n"
        f'    <fixed name={quoteattr(link + "_spring")} stiffness="{_positive(result, "K"):.9g}" '
        f'damping="{damping:.9g}" springlength="{0.0 - half:.9g} {half:.9g}">\n'
        f'      <joint joint={quoteattr(motor)} coef="1"/>\n'
        f'      <joint joint={quoteattr(link)} coef="-1"/>\n'
        f"    </fixed>\n"
        f"  </tendon>\n"
    )


def _yaml(result: StoredResult) -> str:
    values = {p.key: p.value for p in result.parameters}
    return yaml.safe_dump({"/**": {"ros__parameters": {"joint": result.joint, **values}}}, sort_keys=False).rstrip()


def _csv(result: StoredResult) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("joint", "parameter", "value", "std", "unit", "identifiable"))
    for p in result.parameters:
        writer.writerow((result.joint, p.key, f"{p.value:.9g}", f"{p.std:.4g}", p.unit, p.identifiable))
    return text.getvalue().rstrip()
