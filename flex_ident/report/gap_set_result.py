"""`gap.json` of several recordings of one joint: that of one, with what each recording says of each effect."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from flex_ident.gap import GapExplanation
from flex_ident.gap.explanation import GapVerdict
from flex_ident.gap.shared import Proposal
from flex_ident.notices import Code
from flex_ident.parameters import Parameter
from flex_ident.parameters.keys import effect_in, key_parts
from flex_ident.pooling.combining import Pooled
from flex_ident.pooling.effects import STAYS, Heard, Outcome
from flex_ident.report import schemas
from flex_ident.report.gap_set_worded import evidence_text, reason_text
from flex_ident.report.gap_words import region_text, unexplained_text
from flex_ident.report.result import covariance_content, finite, parameters_content
from flex_ident.report.sentences import warning_content
from flex_ident.report.several_result import (
    JoinedResult,
    bag_content,
    recording_content,
    scatter_content,
    torque_constant,
)

OTHERS, ITSELF = "others", "itself"
"""Where the effects' values come from with which a recording's gap was measured."""


@dataclass(frozen=True)
class SetEffect:
    """An effect that a recording found, what each recording says of it, and whether it is the joint's."""

    proposal: Proposal
    heard: tuple[Heard, ...]
    outcome: Outcome

    @property
    def accepted(self) -> bool:
        """Whether it is in the model."""
        return self.outcome in STAYS


@dataclass(frozen=True)
class RecordingGap:
    """A recording's gap, N m rms: of the base, with what was accepted, its noise floor, and after each effect.

    `values_from`: whether the effects have the values that the others found, or those of the recording itself.
    """

    before: float
    after: float
    floor: float
    values_from: Literal["others", "itself"] | str
    steps: tuple[float, ...]


@dataclass(frozen=True)
class JoinedGap:
    """Several recordings' explanation: parameters of all together, each one's own explanation and that by what was
    accepted, the effects (accepted ones first) and the gaps; all in the order of the recordings."""

    joined: JoinedResult
    own: tuple[GapExplanation, ...]
    finals: tuple[GapExplanation, ...]
    effects: tuple[SetEffect, ...]
    gaps: tuple[RecordingGap, ...]

    @property
    def names(self) -> list[str]:
        """The recordings' names."""
        return [member.name for member in self.joined.found.members]

    @property
    def accepted(self) -> list[SetEffect]:
        """The effects of the model."""
        return [own for own in self.effects if own.accepted]

    @property
    def left(self) -> list[str]:
        """What is unexplained, recording by recording."""
        return [
            f"{name}: {unexplained_text(own)}"
            for name, own in zip(self.names, self.finals, strict=True)
            if own.unexplained
        ]

    @property
    def verdict(self) -> GapVerdict:
        """As that of one recording: whether something was named, and whether more than noise is left in any."""
        if any(p.key in ("K", "J") and not p.identifiable for p in self.joined.found.parameters):
            return "rejected"
        if self.accepted:
            return "partly_explained" if self.left else "explained"
        return "unexplained" if self.left else "complete"

    @property
    def unit(self) -> str:
        """The gap's unit."""
        return "A" if self.joined.in_amperes else self.own[0].unit

    @property
    def measured_on(self) -> str:
        """`recordings left out` where the others' values were tried on each, else `validation`."""
        return "recordings left out" if any(own.values_from == OTHERS for own in self.gaps) else "validation"

    def rms(self, values: Sequence[float]) -> float:
        """The root mean square over the recordings."""
        return float(np.sqrt(np.mean(np.square(values))))

    @property
    def steps(self) -> list[tuple[str, float]]:
        """The models, one effect of the joint more in each, and the gap that each leaves over all recordings."""
        names = ["base"]
        for own in self.accepted:
            if not own.proposal.of_recording:
                names.append(f"{names[-1]} + {own.proposal.effect}")
        return [
            (name, self.rms([own.steps[min(i, len(own.steps) - 1)] for own in self.gaps]))
            for i, name in enumerate(names)
        ]

    def pooled(self, effect: SetEffect) -> list[tuple[Parameter, Pooled | None, int]]:
        """The effect's parameters over all recordings, what they scatter by, and their place among the keys."""
        found = self.joined.found
        rows = []
        for p in found.parameters:
            if effect_in(p.key) == effect.proposal.effect:
                k = found.given.keys.index(p.key) if p.key in found.given.keys else -1
                rows.append((p, found.pooled[k] if k >= 0 else None, k))
        return rows


def gap_set_content(result: JoinedGap) -> dict[str, Any]:
    """The content of `gap.json` (schema flex_ident/gap/1)."""
    joined, found = result.joined, result.joined.found
    content: dict[str, Any] = {
        "schema": schemas.GAP, "joint": joined.joint, "bag": bag_content(joined.recordings),
        "sensors": joined.sensors, "verdict": result.verdict,
        "gap": {
            "unit": result.unit, "measured_on": result.measured_on,
            "before": result.rms([own.before for own in result.gaps]),
            "after": result.rms([own.after for own in result.gaps]),
            "noise_floor": result.rms([own.floor for own in result.gaps]),
            "steps": [{"model": name, "gap": gap} for name, gap in result.steps],
        },
        "where": [
            {"recording": name, "variable": r.variable, "range": [r.low, r.high], "share_of_gap": r.share,
             "share_of_time": r.time_share, "text": f"{name}: {region_text(r)}"}
            for name, own in zip(result.names, result.own, strict=True) for r in own.where[:1]
        ],
        "findings": [_finding(result, own) for own in result.accepted],
        "rejected": [
            {"effect": own.proposal.effect, "share_of_gap": _share(own.proposal), "outcome": own.outcome,
             "reason": reason_text(own.proposal, own.heard, own.outcome, result.names),
             "recordings": _heard(result, own)}
            for own in result.effects if not own.accepted
        ],
        "not_testable": [
            {"effect": name, "experiment": next(u.experiment for u in result.own[0].not_testable if u.effect == name)}
            for name in _untestable(result)
        ],
        "unexplained": " ".join(result.left) or None,
        "recordings": [_recording(result, i) for i in range(len(result.names))],
        "left_out": [{"name": n.subject, "why": n.case} for n in joined.left_out],
        "parameters": parameters_content(found.parameters),
        "covariance": covariance_content(found.covariance),
        "scatter": {key: scatter_content(found, k) for k, key in enumerate(found.given.keys)},
        "warnings": [warning_content(n) for n in found.notices if n.code is not Code.RECORDINGS_DOUBTFUL],
    }  # fmt: skip
    if found.scale is not None:
        content["torque_constant"] = torque_constant(found.scale, current=joined.in_amperes)
    return content


def _untestable(result: JoinedGap) -> list[str]:
    """The effects that none of the recordings could have shown."""
    every = [{u.effect for u in own.not_testable} for own in result.own]
    return [u.effect for u in result.own[0].not_testable if all(u.effect in own for own in every)]


def _finding(result: JoinedGap, own: SetEffect) -> dict[str, Any]:
    proposal, names = own.proposal, result.names
    known = [f for f in proposal.findings if f is not None]
    joint = [e for e in result.accepted if not e.proposal.of_recording]
    steps = result.steps
    at = joint.index(own) if own in joint else None
    before, after = (
        (result.rms([f.gap_before for f in known]), result.rms([f.gap_after for f in known]))
        if at is None else (steps[at][1], steps[at + 1][1])
    )  # fmt: skip
    ties = set.intersection(*(set(f.indistinguishable_from) for f in known))
    content: dict[str, Any] = {
        "effect": proposal.effect, "verdict": own.outcome, "of": "recording" if proposal.of_recording else "joint",
        "confidence": max(f.confidence for f in known), "gap_before": before, "gap_after": after,
        "parameters": {
            key_parts(key)[1]: p for key, p in parameters_content([p for p, _, _ in result.pooled(own)]).items()
        },
        "agree": {key_parts(p.key)[1]: finite(o.chance) for p, o, _ in result.pooled(own) if o is not None},
        "evidence": evidence_text(proposal, own.heard, names), "found_in": [names[i] for i in proposal.finders],
        "validated": any(h.said == "confirms" for h in own.heard),
        "recordings": _heard(result, own),
        "also_considered": [],
    }  # fmt: skip
    if ties:
        content["indistinguishable_from"] = sorted(ties)
        content["experiment"] = next(f.experiment for f in known if f.experiment)
    return content


def _heard(result: JoinedGap, own: SetEffect) -> list[dict[str, Any]]:
    return [
        {"name": name, "found": h.found, "others_values": h.said, "gap_before": _number(h.before),
         "gap_after": _number(h.after), "t": _number(h.t),
         "parameters": {} if f is None else parameters_content(f.parameters)}
        for name, h, f in zip(result.names, own.heard, own.proposal.findings, strict=True)
    ]  # fmt: skip


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _share(proposal: Proposal) -> float:
    known = [f for f in proposal.findings if f is not None]
    return max(1.0 - (f.gap_after / f.gap_before) ** 2 for f in known)


def _recording(result: JoinedGap, i: int) -> dict[str, Any]:
    gap, own, final = result.gaps[i], result.own[i], result.finals[i]
    return {
        **recording_content(result.joined, i), "verdict": own.verdict,
        "findings": [f.effect for f in own.findings],
        "gap": {"before": gap.before, "after": gap.after, "noise_floor": gap.floor, "values_from": gap.values_from},
        "by_itself": {"before": own.before, "after": own.after, "noise_floor": own.noise_floor},
        "unexplained": unexplained_text(final) or None,
    }  # fmt: skip
