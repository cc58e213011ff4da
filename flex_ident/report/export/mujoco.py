"""MuJoCo: a whole model of link and rotor about one axis, with a tendon between them as the spring."""

from __future__ import annotations

import math
from xml.sax.saxutils import quoteattr

from flex_ident.effects import CATALOGUE
from flex_ident.parameters.keys import key_text
from flex_ident.report.export.remarks import remarks
from flex_ident.report.stored import StoredResult
from flex_ident.simulation.terms import GRAVITY, Term

ROTOR_SHARE = 1e-6
"""Inertia of the rotor's body over its armature: MuJoCo wants a mass and an inertia of every body that moves."""
STEPS_PER_PERIOD = 40.0
"""Time steps in a period of the free resonance."""
LONGEST_STEP_S = 1e-3
LINK_TERMS = (Term.GRAVITY_COS, Term.GRAVITY_SIN)
CABLE_TERMS = (Term.CABLE_STIFFNESS, Term.CABLE_TORQUE)
TENDON_TERMS = (Term.HALF_GAP, Term.SPRING_DAMPING)
"""Terms that the MuJoCo model holds; effects that add to others are named as left out."""


def written(result: StoredResult) -> str:
    """A whole MuJoCo model: link and rotor about one axis, each with its friction, a tendon between them as the spring.

    Both hang from the base, so that each one's friction acts against it as in eqs. 5 and 6; the actuator takes the
    motor's torque on the link side of the gear. A rigid joint is one body.
    """
    rigid = result.rigid
    step = LONGEST_STEP_S if rigid else min(LONGEST_STEP_S, 1.0 / (STEPS_PER_PERIOD * _free_resonance_hz(result)))
    step = float(f"{step:.1e}")
    link, motor = result.joint, result.joint if rigid else f"{result.joint}_motor"
    inertia = result.positive("J" if rigid else "JL")
    bodies = _link_body(result, link, inertia, step)
    tendon = ""
    texts = [
        "The axis is horizontal and the zero position that of the recording: link weight is MX g cos q + MY g sin q.",
        "Only inertia about the axis and first moments were identified: mass and place of the centre of mass go with "
        "them, but stand for no others.",
    ]
    if result.slides:
        texts = ["The axis is horizontal: what gravity does along it is in the motor's constant force."]
    if not rigid:
        bodies += _rotor_body(result, motor, step)
        tendon = _spring(result, link, motor)
        texts.append(f"{motor} is the rotor on the link side of the gear, and the tendon the joint's spring.")
    offset = result.number("offset") if result.determines("offset") else 0.0
    if not result.determines("offset"):
        texts.append("The motor has no constant force here: the recording does not determine it.")
    constant = f' biastype="affine" biasprm="{-offset:.9g} 0 0"' if offset else ""
    terms = (*LINK_TERMS, *(() if rigid else TENDON_TERMS), *(CABLE_TERMS if _cable(result) else ()))
    held = tuple(key for term in terms for key in _adding_to(term))
    return (
        f"{remarks(result, *texts, held=held)}\n"
        f"<mujoco model={quoteattr(result.joint)}>\n"
        f'  <compiler angle="radian"/>\n'
        f'  <option timestep="{step:.6g}" gravity="0 0 -{GRAVITY}" integrator="implicitfast"/>\n'
        f"  <worldbody>\n{bodies}  </worldbody>\n{tendon}"
        f"  <actuator>\n"
        f"    <general name={quoteattr(motor)} joint={quoteattr(motor)}{constant}/>\n"
        f"  </actuator>\n"
        f"</mujoco>"
    )


def _adding_to(term: Term) -> dict[str, float]:
    """Keys of the effects' parameters that add to a term, and the factor of each."""
    every = ((effect.name, p) for effect in CATALOGUE.values() for p in effect.parameters)
    return {key_text(effect, p.name): p.factor for effect, p in every if p.term is term}


def _term(result: StoredResult, term: Term, *, lowest: float = -math.inf) -> float:
    """What the effects of a result add to a term, each at least `lowest`."""
    return sum(factor * result.number(key, lowest=lowest) for key, factor in _adding_to(term).items())


def _free_resonance_hz(result: StoredResult) -> float:
    compliance = 1.0 / result.positive("Jm") + 1.0 / result.positive("JL")
    return math.sqrt(result.positive("K") * compliance) / (2.0 * math.pi)


def _cable(result: StoredResult) -> str:
    """The link's spring to ground as attributes of its joint; empty where it has none that MuJoCo knows."""
    stiffness, pull = (_term(result, term) for term in CABLE_TERMS)
    return f' stiffness="{stiffness:.9g}" springref="{-pull / stiffness:.9g}"' if stiffness > 0.0 else ""


def _joint_element(
    name: str, kind: str, viscous: float, dry: float, step: float, armature: float = 0.0, cable: str = ""
) -> str:
    """A joint; dry friction as stiff a constraint as the time step allows."""
    rotor = (f' armature="{armature:.9g}"' if armature else "") + cable
    friction = f' frictionloss="{dry:.9g}" solreffriction="{2.0 * step:.6g} 1"' if dry else ""
    return f'<joint name={quoteattr(name)} {kind}{rotor} damping="{viscous:.9g}"{friction}/>'


def _link_body(result: StoredResult, name: str, inertia: float, step: float) -> str:
    """The link: `inertia` about the axis, and a centre of mass that gives MX and MY.

    The mass is not identified: it is what leaves half of the inertia to the centre of mass's own.
    """
    viscous, dry = (result.number(k, lowest=0.0) for k in ("FV", "FS"))
    kind, mass, own, place = 'type="hinge" axis="0 1 0"', 1.0, inertia, (0.0, 0.0)
    if result.slides:
        kind, mass = 'type="slide" axis="1 0 0"', inertia
    else:
        mx = result.number("MX") + _term(result, Term.GRAVITY_COS) / GRAVITY
        my = result.number("MY") + _term(result, Term.GRAVITY_SIN) / GRAVITY
        moment = math.hypot(mx, my)
        if moment > 0.0:
            mass = 2.0 * moment**2 / inertia
            own, place = 0.5 * inertia, (-mx / mass, -my / mass)
    joint = _joint_element(name, kind, viscous, dry, step, cable=_cable(result))
    return (
        f"    <body name={quoteattr(name + '_link')}>\n"
        f'      <inertial pos="{place[0]:.9g} 0 {place[1]:.9g}" mass="{mass:.9g}" '
        f'diaginertia="{own:.9g} {own:.9g} {own:.9g}"/>\n'
        f"      {joint}\n"
        f"    </body>\n"
    )


def _rotor_body(result: StoredResult, name: str, step: float) -> str:
    """The rotor: its inertia is the joint's armature, the body is there because MuJoCo wants one."""
    inertia = result.positive("Jm")
    small = ROTOR_SHARE * inertia
    kind = 'type="slide" axis="1 0 0"' if result.slides else 'type="hinge" axis="0 1 0"'
    viscous, dry = (result.number(k, lowest=0.0) for k in ("FVm", "FSm"))
    joint = _joint_element(name, kind, viscous, dry, step, armature=inertia)
    return (
        f"    <body name={quoteattr(name)}>\n"
        f'      <inertial pos="0 0 0" mass="{small:.9g}" diaginertia="{small:.9g} {small:.9g} {small:.9g}"/>\n'
        f"      {joint}\n"
        f"    </body>\n"
    )


def _spring(result: StoredResult, link: str, motor: str) -> str:
    """The spring as a fixed tendon from link to rotor; its dead band is the backlash."""
    half = _term(result, Term.HALF_GAP, lowest=0.0)
    damping = _term(result, Term.SPRING_DAMPING, lowest=0.0)
    return (
        f"  <tendon>\n"
        f'    <fixed name={quoteattr(link + "_spring")} stiffness="{result.positive("K"):.9g}" '
        f'damping="{damping:.9g}" springlength="{0.0 - half:.9g} {half:.9g}">\n'
        f'      <joint joint={quoteattr(motor)} coef="1"/>\n'
        f'      <joint joint={quoteattr(link)} coef="-1"/>\n'
        f"    </fixed>\n"
        f"  </tendon>\n"
    )
