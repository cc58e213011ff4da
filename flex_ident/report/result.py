"""`result.json`: the public form of an identification."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from flex_ident import __version__
from flex_ident.parameters import Covariance, Identification, Parameter
from flex_ident.recording import Recording
from flex_ident.report import schemas
from flex_ident.report.answers import answer_content
from flex_ident.report.sentences import warning_content
from flex_ident.report.units import words_of


def finite(value: float) -> float | None:
    """The number, or None where JSON has no word for it."""
    return float(value) if math.isfinite(value) else None


def parameters_content(parameters: Iterable[Parameter]) -> dict[str, Any]:
    """Parameters by key, each with its uncertainty, unit and whether the data determine it."""
    content: dict[str, Any] = {}
    for p in parameters:
        low, high = p.interval
        content[p.key] = {
            "value": finite(p.value), "std": finite(p.std), "ci95": [finite(low), finite(high)],
            "relative_std_percent": finite(p.relative_std_percent), "unit": p.unit, "identifiable": p.identifiable,
        }  # fmt: skip
        if p.at_bound:
            content[p.key]["at_bound"] = True
    return content


def sampling_content(recording: Recording) -> list[dict[str, Any]]:
    """How each channel was sampled and what was done to it."""
    return [
        {
            "signal": s.role, "source": s.source, "clock": s.clock, "samples": s.samples, "rate_hz": finite(s.rate_hz),
            "jitter_percent": finite(s.jitter_percent), "lost_percent": finite(s.lost_percent),
            "longest_gap_s": finite(s.longest_gap_s), "skew_s": finite(s.skew_s),
            "dropped_nonfinite": s.dropped_nonfinite, "dropped_duplicates": s.dropped_duplicates,
            "dropped_backwards": s.dropped_backwards,
        }
        for s in recording.sampling
    ]  # fmt: skip


def result_content(result: Identification, recording: Recording) -> dict[str, Any]:
    """The content of `result.json` (schema flex_ident/result/1 of INTERFACE.md)."""
    content: dict[str, Any] = {
        "schema": schemas.RESULT, "flex_ident_version": __version__, "joint": result.joint,
        "bag": {"path": recording.path, "sha256": recording.sha256},
        "sensors": result.sensors, "method": result.method, "verdict": result.verdict,
        "parameters": parameters_content(result.parameters),
        "combined": parameters_content(result.combined),
        "derived": numbers(result.derived),
        "measurement": parameters_content(result.measurement),
        "fit": {
            "samples": result.fit.samples, "condition_number": finite(result.fit.condition_number),
            "rank": result.fit.rank, "relative_error_percent": finite(result.fit.relative_error_percent),
            "validation_relative_error_percent": finite(result.fit.validation_relative_error_percent),
        },
        "recording": {
            "duration_s": float(recording.time[-1]) if recording.time.size else 0.0,
            "sample_rate_hz": recording.sample_rate_hz, "channels": sampling_content(recording),
        },
        "answers": answer_content(result, recording),
        "warnings": [warning_content(n) for n in result.notices],
    }  # fmt: skip
    if result.covariance is not None:
        content["covariance"] = covariance_content(result.covariance)
    if result.filter is not None:
        f = result.filter
        content["filter"] = {
            "bandwidth_rad_s": f.bandwidth_rad_s, "cutoff_rad_s": f.cutoff_rad_s, "order": f.order,
            "sample_rate_hz": f.sample_rate_hz, "decimation": f.decimation,
        }  # fmt: skip
    if result.cutoff_sweep is not None:
        sweep = result.cutoff_sweep
        content["cutoff_sweep"] = {
            "cutoff_rad_s": sweep.cutoff_rad_s.tolist(),
            "values": {k: [finite(x) for x in v] for k, v in sweep.values.items()},
            "stds": {k: [finite(x) for x in v] for k, v in sweep.stds.items()},
        }
    if result.friction_curve is not None:
        curve = result.friction_curve
        content["friction_curve"] = {
            "speed": curve.speed.tolist(), "friction": curve.friction.tolist(), "std": curve.std.tolist(),
            "ci95": [curve.lower.tolist(), curve.upper.tolist()], **friction_units(result),
        }  # fmt: skip
    return content


def covariance_content(covariance: Covariance) -> dict[str, Any]:
    """Keys and matrix of a covariance; what the data leave open is not in it."""
    return {"keys": list(covariance.keys), "matrix": covariance.matrix.tolist()}


def friction_units(result: Identification) -> dict[str, str]:
    """Units of a friction curve's speed and friction."""
    words = words_of(result)
    return {"speed_unit": words("rad/s"), "friction_unit": words("N m")}


def numbers(values: Mapping[str, float]) -> dict[str, float | None]:
    """A mapping of numbers that JSON can hold."""
    return {k: finite(v) for k, v in values.items()}
