"""The health of a joint by its latest result, as a diagnostic message: its verdict, and what a baseline says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from flex_ident.errors import FlexIdentError
from flex_ident.report.comparison import joint_agreement, joint_text
from flex_ident.report.stored import StoredResult, result_in, stored_result

LEVELS = {
    "trusted": DiagnosticStatus.OK, "complete": DiagnosticStatus.OK, "explained": DiagnosticStatus.OK,
    "doubtful": DiagnosticStatus.WARN, "partly_explained": DiagnosticStatus.WARN,
    "unexplained": DiagnosticStatus.WARN, "rejected": DiagnosticStatus.ERROR,
}  # fmt: skip
"""The level of each verdict."""


def health_of(content: Mapping[str, Any], node: str, baseline: Callable[[], Path | None]) -> DiagnosticStatus:
    """The status of a result's content: its verdict, and whether it agrees with the result at `baseline`, if any.

    A baseline that cannot be read, or may not be, is a warning that says why: the result is no worse for it.
    """
    joint, verdict = str(content["joint"]), str(content["verdict"])
    status = DiagnosticStatus(level=LEVELS[verdict], name=f"{node}: {joint}", hardware_id=joint)
    now = result_in(dict(content), Path("result.json"))
    said = [verdict.replace("_", " ")]
    values = {"verdict": verdict, "warnings": ",".join(w["code"] for w in content.get("warnings", []))}
    for p in now.parameters:
        if p.identifiable:
            values |= {p.key: f"{p.value:.6g}", f"{p.key}.std": f"{p.std:.3g}", f"{p.key}.unit": p.unit}
    differs = False
    try:
        path = baseline()
        if path is not None:
            before = stored_result(path)
            differs = not _agree(before, now, values)
            said.append(f"{'changed: ' if differs else ''}{joint_text(before, now)}")
    except FlexIdentError as error:
        differs = True
        said.append(f"no baseline: {error}")
    if differs and status.level == DiagnosticStatus.OK:
        status.level = DiagnosticStatus.WARN
    status.message = "; ".join(said)
    status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
    return status


def failed(node: str, why: str) -> DiagnosticStatus:
    """The status where there is no result."""
    return DiagnosticStatus(level=DiagnosticStatus.ERROR, name=f"{node}: no result", message=why)


def _agree(before: StoredResult, now: StoredResult, values: dict[str, str]) -> bool:
    """Whether the two agree, as far as that can be judged; noted in `values` with the change of each parameter."""
    found = joint_agreement(before, now)
    values["agrees"] = "not judged" if found is None else "yes" if found.agree else "no"
    if found is not None:
        values |= {"chance": f"{found.chance:.3g}", "differs_most": found.farthest}
    for p in now.parameters:
        if p.identifiable and before.value(p.key) and before.unit(p.key) == p.unit:
            values[f"{p.key}.change_percent"] = f"{100.0 * (p.value / before.value(p.key) - 1.0):.3g}"
    return found is None or found.agree
