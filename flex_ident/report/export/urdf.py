"""URDF: friction as the dynamics of a joint, the rotor as transmissions have it."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from flex_ident.report.export.remarks import remarks
from flex_ident.report.stored import StoredResult


def written(result: StoredResult) -> str:
    """URDF has no elastic joint: friction as joint dynamics, the rotor as transmissions have it."""
    rigid = result.rigid
    viscous = sum(result.number(k, lowest=0.0) for k in ("FVm", "FV"))
    dry = sum(result.number(k, lowest=0.0) for k in ("FSm", "FS"))
    name = quoteattr(result.joint)
    joint = (
        f"<joint name={name}>\n"
        f'  <dynamics damping="{viscous:.6g}" friction="{dry:.6g}"/>\n'
        f"</joint>"
    )  # fmt: skip
    merge = "Put the <dynamics> into the robot's own <joint>."
    if rigid:
        text = (
            f"J = {result.positive('J'):.6g} {result.unit('J')}, motor and link together about the joint's axis, "
            "is left out: URDF keeps inertia in the <inertial> of links."
        )
        return f"{remarks(result, text, merge)}\n{joint}"
    text = (
        f"URDF has no spring: K = {result.positive('K'):.6g} {result.unit('K')} is left out, and friction of "
        f"motor and link is one. JL = {result.positive('JL'):.6g} {result.unit('JL')} about the joint's axis is "
        "left out: URDF keeps inertia in the <inertial> of links. motorInertia is on the link side of the gear."
    )
    return (
        f"{remarks(result, text, merge)}\n{joint}\n"
        f"<transmission name={quoteattr(result.joint + '_transmission')}>\n"
        f"  <type>transmission_interface/SimpleTransmission</type>\n"
        f"  <joint name={name}/>\n"
        f"  <actuator name={quoteattr(result.joint + '_motor')}>\n"
        f"    <mechanicalReduction>1</mechanicalReduction>\n"
        f"    <motorInertia>{result.positive('Jm'):.6g}</motorInertia>\n"
        f"  </actuator>\n"
        f"</transmission>"
    )
