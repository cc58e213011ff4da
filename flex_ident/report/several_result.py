"""`result.json` of several recordings of one joint: that of one, with `recordings`, `scatter` and `torque_constant`."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flex_ident import __version__
from flex_ident.notices import Notice
from flex_ident.parameters import Identification, JointModel
from flex_ident.parameters.values import Values
from flex_ident.pooling.several import Several
from flex_ident.pooling.torque_scale import Estimate, TorqueScale
from flex_ident.recording import Recording
from flex_ident.report import schemas
from flex_ident.report.result import covariance_content, finite, parameters_content
from flex_ident.report.sentences import warning_content

METHOD = "several"


@dataclass(frozen=True)
class JoinedResult:
    """Several recordings together, and the result and the recording of each that is used, in the order of members.

    `in_amperes`: the efforts are a current, and so are the recordings' own values.
    """

    found: Several
    results: Sequence[Identification]
    recordings: Sequence[Recording]
    in_amperes: bool = False
    left_out: tuple[Notice, ...] = ()

    @property
    def joint(self) -> str:
        """The joint's name in the first recording."""
        return self.results[0].joint

    @property
    def sensors(self) -> str:
        """The richest set of sensors among the recordings."""
        return "motor+link" if any(r.sensors == "motor+link" for r in self.results) else "motor"

    @property
    def model(self) -> JointModel:
        """The joint's model with the values of all recordings together."""
        values = Values({p.key: p.value for p in self.found.parameters if math.isfinite(p.value)})
        return JointModel(values.base, values.effects, joint=self.joint)


def several_content(joined: JoinedResult) -> dict[str, Any]:
    """The content of `result.json` (schema flex_ident/result/1)."""
    found = joined.found
    content: dict[str, Any] = {
        "schema": schemas.RESULT, "flex_ident_version": __version__, "joint": joined.joint,
        "bag": bag_content(joined.recordings),
        "sensors": joined.sensors, "method": METHOD, "verdict": found.verdict,
        "parameters": parameters_content(found.parameters),
        "covariance": covariance_content(found.covariance),
        "fit": {"samples": sum(result.fit.samples for result in joined.results)},
        "recordings": [recording_content(joined, i) for i in range(len(joined.results))],
        "left_out": [{"name": n.subject, "why": n.case} for n in joined.left_out],
        "scatter": {key: scatter_content(found, k) for k, key in enumerate(found.given.keys)},
        "warnings": [warning_content(n) for n in found.notices],
    }  # fmt: skip
    if found.scale is not None:
        content["torque_constant"] = torque_constant(found.scale, current=joined.in_amperes)
    return content


def bag_content(recordings: Sequence[Recording]) -> dict[str, Any]:
    """Path and hash of a set: those of all of its recordings."""
    hashes = "".join(recording.sha256 for recording in recordings)
    return {
        "path": ", ".join(recording.path for recording in recordings),
        "sha256": hashlib.sha256(hashes.encode()).hexdigest(),
    }


def recording_content(joined: JoinedResult, i: int) -> dict[str, Any]:
    """What is said of recording `i` of a set."""
    found, result, recording = joined.found, joined.results[i], joined.recordings[i]
    member = found.members[i]
    apart = next((own for own in found.disagreements if own.index == i), None)
    return {
        "name": member.name, "path": recording.path, "sha256": recording.sha256, "joint": result.joint,
        "sensors": result.sensors, "verdict": result.verdict, "sample_rate_hz": recording.sample_rate_hz,
        "parameters": parameters_content(result.parameters),
        "weight": weights(found, i),
        "disagreement": None if apart is None else {"key": apart.key, "stds": apart.stds, "chance": apart.chance},
        "conditions": dict(member.conditions),
        "warnings": [warning_content(n) for n in result.notices],
    }  # fmt: skip


def weights(found: Several, i: int) -> dict[str, float]:
    """What recording `i` weighs in each parameter: 0 where it does not determine it."""
    result = {}
    for k, key in enumerate(found.given.keys):
        rows = [j for j in range(len(found.members)) if found.given.there[j, k]]
        result[key] = float(found.pooled[k].weights[rows.index(i)]) if i in rows else 0.0
    return result


def scatter_content(found: Several, k: int) -> dict[str, Any]:
    """How parameter number `k` scatters between the recordings."""
    own = found.pooled[k]
    cause = next((c for c in found.causes if c.key == found.given.keys[k]), None)
    size = found.multiplied * own.scatter
    return {
        "std": size, "relative_percent": finite(100.0 * own.scatter / abs(own.value)) if own.value else None,
        "chance": finite(own.chance), "recordings": int(own.weights.size),
        "condition": None if cause is None else {
            "name": cause.condition, "share": cause.share, "chance": cause.chance, "alike": list(cause.alike),
            "slope": None if cause.slope is None else found.multiplied * cause.slope,
        },
    }  # fmt: skip


def torque_constant(scale: TorqueScale, *, current: bool) -> dict[str, Any]:
    """What a known mass says of the effort's scale."""
    return {
        "outcome": scale.outcome, "unit": "N m/A" if current else "",
        "scale": _estimate(scale.both), "from_inertia": _estimate(scale.inertia),
        "from_gravity": _estimate(scale.gravity), "agree": scale.agree,
        "chance": None if scale.chance is None else finite(scale.chance),
        "gravity_turned_deg": None if scale.angle is None else math.degrees(scale.angle),
    }  # fmt: skip


def _estimate(own: Estimate | None) -> dict[str, Any] | None:
    return None if own is None else {"value": own.value, "std": own.std, "ci95": [own.low, own.high]}
