"""`gap.json`: the public form of an explanation, as INTERFACE.md gives it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from flex_ident.gap.explanation import Finding, GapExplanation, Region, Step
from flex_ident.gap.measured import MeasuredCurve
from flex_ident.likelihood.repeats import Repeats
from flex_ident.parameters import Parameter
from flex_ident.report import schemas
from flex_ident.report.gap_words import evidence_text, reading_text, region_text, rejected_text, unexplained_text
from flex_ident.report.result import covariance_content
from flex_ident.report.sentences import warning_content
from flex_ident.report.units import Words, words_of


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _parameter(p: Parameter) -> dict[str, Any]:
    low, high = p.interval
    return {
        "value": _finite(p.value), "std": _finite(p.std), "ci95": [_finite(low), _finite(high)], "unit": p.unit,
        "relative_std_percent": _finite(p.relative_std_percent), "identifiable": p.identifiable,
    }  # fmt: skip


def _regions(found: Sequence[Region]) -> list[dict[str, Any]]:
    return [
        {"variable": r.variable, "range": [r.low, r.high], "share_of_gap": r.share, "share_of_time": r.time_share,
         "text": region_text(r)}
        for r in found
    ]  # fmt: skip


def _finding(f: Finding, words: Words) -> dict[str, Any]:
    content: dict[str, Any] = {
        "effect": f.effect, "verdict": f.verdict, "confidence": f.confidence, "gap_before": f.gap_before,
        "gap_after": f.gap_after, "parameters": {p.key: _parameter(p) for p in f.parameters},
        "evidence": evidence_text(f, words),
        "also_considered": [{"effect": a.effect, "gap_after": _finite(a.gap_after)} for a in f.also_considered],
    }  # fmt: skip
    if f.curve is not None:
        content["curve"] = _curve(f.curve, reading_text(f, words))
    if f.indistinguishable_from:
        content["indistinguishable_from"] = list(f.indistinguishable_from)
        content["experiment"] = f.experiment
    return content


def _curve(c: MeasuredCurve, reading: str) -> dict[str, Any]:
    """A measured law: torque at places of a variable, the ends of its 95 % band, and what it looks like."""
    rows = {"at": c.at, "torque": c.torque, "lower": c.lower, "upper": c.upper, "points": c.points}
    listed = {name: [float(x) for x in row] for name, row in rows.items()}
    return {"variable": c.variable, "unit": c.unit, "reading": reading, **listed}


def _repeats(r: Repeats | None) -> dict[str, float] | None:
    return None if r is None else {"period_s": r.period_s, "repeatable": r.repeatable, "noise": r.noise}


def _step(s: Step) -> dict[str, Any]:
    return {"model": s.model, "gap": s.gap, **({} if s.link_gap is None else {"link_gap": s.link_gap})}


def gap_content(explanation: GapExplanation) -> dict[str, Any]:
    """The content of `gap.json` (schema flex_ident/gap/1)."""
    e, words = explanation, words_of(explanation.final)
    known = e.final.covariance
    return {
        "schema": schemas.GAP, "joint": e.joint, "sensors": e.sensors, "verdict": e.verdict,
        "gap": {
            "unit": e.unit, "measured_on": "validation", "before": e.before, "after": e.after,
            "noise_floor": e.noise_floor, "method_error": e.method_error, "closed": e.closed,
            "steps": [_step(s) for s in e.steps],
            "repeats": {"before": _repeats(e.repeats), "after": _repeats(e.repeats_left)} if e.repeats else None,
        },
        "where": _regions(e.where), "where_left": _regions(e.where_left),
        "findings": [_finding(f, words) for f in e.findings],
        "rejected": [
            {"effect": r.effect, "share_of_gap": r.share, "code": str(r.reason.why), "reason": rejected_text(r, words)}
            for r in e.rejected
        ],
        "not_testable": [
            {"effect": u.effect, "orthogonal_share": u.orthogonal, "experiment": u.experiment} for u in e.not_testable
        ],
        "unexplained": unexplained_text(e) or None,
        "parameters": {p.key: _parameter(p) for p in e.final.parameters},
        **({} if known is None else {"covariance": covariance_content(known)}),
        "warnings": [warning_content(n) for n in (*e.notices, *e.final.notices)],
    }  # fmt: skip
