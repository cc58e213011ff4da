"""The health of a fleet as one page: what changed and why, every changed joint's series, what could have been shown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.report.figures import LINK, MEASURED, PREDICTED, QUIET, embedded, png_bytes, styled_figure
from flex_ident.report.folder import REPORT, renewed
from flex_ident.report.health_table import (
    CAUSES,
    HEADER,
    TO_CONFIRM,
    change_row,
    counted_states,
    limits_text,
    mixed_lines,
    smallest_rows,
    worded,
)
from flex_ident.report.page import Image, Merit, Row, Section, page_html

HEALTH = "health.json"
MOST_DRAWN = 24
"""Joints that are drawn, those that changed first."""
COLUMNS = 4


def write_health(content: Mapping[str, Any], folder: Path) -> dict[str, Path]:
    """Write report.html and health.json; what was written, by name. Raises UsageError."""
    with renewed(folder, (REPORT, HEALTH)) as aside:
        (aside / HEALTH).write_text(json.dumps(worded(content), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        (aside / REPORT).write_text(health_html(content), encoding="utf-8")
    return {name: folder / name for name in (HEALTH, REPORT)}


def health_html(content: Mapping[str, Any]) -> str:
    """The page of `fleet_health`'s content."""
    joints = content["joints"]
    order = ("changed", "to_confirm", "unchanged")
    drawn = sorted((j for j in joints if j["parameters"]), key=lambda j: order.index(j["state"]))[:MOST_DRAWN]
    held = content["false_alarms"]
    changed = [j for j in joints if j["state"] == "changed"]
    merits = [Merit(text, str(count)) for text, count in counted_states(content)]
    sections = [
        Section(
            "What changed",
            ("Nothing that scatter alone would not do.",) if not content["changes"] else (),
            items=tuple(f"{_name(j)}: {CAUSES[j['cause']]}." for j in changed),
            header=HEADER, rows=tuple(Row(change_row(own)) for own in content["changes"]), right=(3, 4, 6, 7, 8),
            notes=(
                f"Baseline: {content['baseline']}. Of the changes named no more than {100 * held['rate']:.0f} % are "
                f"false on average ({held['method']} over {held['comparisons']} comparisons). A cause is a first place "
                "to look.",
            ),
        ),
        *_waiting(content),
        *([Section("Not compared", tuple(mixed))] if (mixed := mixed_lines(content)[1:]) else []),
        Section(
            "What this archive could have shown", (limits_text(content),),
            header=("parameter", "smallest change, median", "worst joint", "joints"), right=(1, 2, 3),
            rows=tuple(Row(row) for row in smallest_rows(content)),
            notes=(
                "A change of that size, right behind the baseline, would have been found in 95 of 100. Smaller ones "
                "may be there: more sessions a joint, or recordings at one temperature, payload and motion, show them.",
            ),
        ),
        *(
            Section(_title(j), images=(Image(embedded(joint_plot(j)), f"parameters of {_name(j)} over time"),))
            for j in drawn
        ),
    ]  # fmt: skip
    more = sum(bool(j["parameters"]) for j in joints) - len(drawn)
    if more:
        sections.append(Section("Further joints", (f"{more} more joints are in {HEALTH}, and are not drawn.",)))
    return page_html(
        title="Health of the fleet", heading="Health of the fleet", verdict="changed" if changed else "unchanged",
        summary=f"{len(changed)} of {len(joints)} joints changed.", merits=merits, sections=sections,
        source="Points: results with their stated 95 % intervals, in percent of the baseline where it is not zero. "
        "Green: baseline. Red: changed.",
    )  # fmt: skip


def _waiting(content: Mapping[str, Any]) -> list[Section]:
    if not content["to_confirm"]:
        return []
    text = f"{TO_CONFIRM[:-1]}. An outlier does that as well."
    rows = tuple(Row(change_row(own)) for own in content["to_confirm"])
    return [Section("To confirm", (text,), header=HEADER, rows=rows, right=(3, 4, 6, 7, 8))]


def _title(joint: Mapping[str, Any]) -> str:
    return f"{_name(joint)}: {joint['state'].replace('_', ' ')}"


def _name(joint: Mapping[str, Any]) -> str:
    return f"{joint['robot']} {joint['joint']}".strip()


def joint_plot(joint: Mapping[str, Any]) -> bytes:
    """A panel a parameter: its results over time, in percent of the mean of the baseline; changed ones in red."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

    parameters = joint["parameters"]
    keys = sorted(parameters, key=lambda key: not parameters[key]["changed"])
    times = [datetime.fromisoformat(text) for text in joint["recorded_at"]]
    rows = -(-len(keys) // COLUMNS)
    with styled_figure(8.8, 1.55 * rows + 0.2) as figure:
        axes = np.atleast_1d(figure.subplots(rows, COLUMNS)).ravel()
        for a, key in zip(axes, keys, strict=False):
            own = parameters[key]
            at = date2num([times[i] for i in own["results"]])
            first = [i < joint["baseline_results"] for i in own["results"]]
            values, stds = np.array(own["values"]), np.array(own["stds"])
            centre = float(np.mean(values[first]))
            size = abs(centre) if abs(centre) > 3.0 * float(np.median(stds)) else 0.0
            shown, errors = (100.0 * (values / centre - 1.0), 196.0 * stds / size) if size else (values, 1.96 * stds)
            colour = PREDICTED if own["changed"] else MEASURED
            a.axhline(0.0 if size else centre, color=QUIET, lw=0.8)
            for rows_of, c in ((first, LINK), ([not own for own in first], colour)):
                a.errorbar(at[rows_of], shown[rows_of], yerr=errors[rows_of], fmt="o", ms=3.2, lw=0.9, color=c)
            a.set_title(f"{key}, {'%' if size else own['unit']}", fontsize=8.5, color=colour)
            a.xaxis.set_major_locator(AutoDateLocator(minticks=2, maxticks=4))
            a.xaxis.set_major_formatter(ConciseDateFormatter(a.xaxis.get_major_locator(), show_offset=False))
            a.tick_params(labelsize=7)
            a.margins(x=0.08)
        for a in axes[len(keys) :]:
            a.set_visible(False)
        return png_bytes(figure)
