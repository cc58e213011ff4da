"""`flex_ident export`: a result in the words of other tools."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import yaml

from flex_ident.commands.formats import FORMATS
from flex_ident.commands.results import StoredResult, stored_result
from flex_ident.errors import UsageError


def exported(path: Path, to: str) -> str:
    """The result in `path` as text in one of FORMATS. Raises UsageError and DataError."""
    writers: dict[str, Callable[[StoredResult], str]] = {
        "urdf": _urdf, "mujoco": _mujoco, "yaml": _yaml, "csv": _csv,
    }  # fmt: skip
    if to not in writers:
        raise UsageError(f"--to is '{to}': expected one of {', '.join(FORMATS)}.")
    return writers[to](stored_result(path))


def _viscous(result: StoredResult) -> float:
    return result.value("FVm") + result.value("FV")


def _dry(result: StoredResult) -> float:
    return result.value("FSm") + result.value("FS")


def _inertia(result: StoredResult) -> float:
    return result.value("J") or result.value("Jm")


def _urdf(result: StoredResult) -> str:
    """URDF has no elastic joint: friction as joint dynamics, the rotor as ros2_control and Gazebo know it."""
    return (
        f"<!-- {result.joint}: {result.verdict}, {result.path.name}. URDF has no spring: K = "
        f"{result.value('K'):.6g} N m/rad and JL = {result.value('JL'):.6g} kg m^2 are left out. -->\n"
        f'<joint name="{result.joint}">\n'
        f'  <dynamics damping="{_viscous(result):.6g}" friction="{_dry(result):.6g}"/>\n'
        f"</joint>\n"
        f'<transmission name="{result.joint}_transmission">\n'
        f'  <actuator name="{result.joint}_motor"><motorInertia>{_inertia(result):.6g}</motorInertia></actuator>\n'
        f"</transmission>"
    )


def _mujoco(result: StoredResult) -> str:
    """A motor joint and a link joint behind a spring; of a rigid joint, one joint."""
    if result.value("J"):
        return (
            f'<joint name="{result.joint}" armature="{result.value("J"):.6g}" damping="{result.value("FV"):.6g}" '
            f'frictionloss="{result.value("FS"):.6g}"/>'
        )
    return (
        f"<!-- {result.joint}: {result.verdict}. The motor's body turns the link's body through a spring joint. -->\n"
        f'<body name="{result.joint}_motor">\n'
        f'  <joint name="{result.joint}" armature="{result.value("Jm"):.6g}" damping="{result.value("FVm"):.6g}" '
        f'frictionloss="{result.value("FSm"):.6g}"/>\n'
        f'  <body name="{result.joint}_link">\n'
        f'    <joint name="{result.joint}_deflection" stiffness="{result.value("K"):.6g}"/>\n'
        f"    <!-- inertia about the axis, JL = {result.value('JL'):.6g} kg m^2; friction of the link, FV = "
        f"{result.value('FV'):.6g} N m s/rad and FS = {result.value('FS'):.6g} N m, acts against the base -->\n"
        f"  </body>\n"
        f"</body>"
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
