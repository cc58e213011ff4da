"""All files of several recordings' explanation in one folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flex_ident.report.folder import EXPLANATION, GAP_REPORT, IDENTIFICATION, MODELS, REPORT, renewed, stored_content
from flex_ident.report.gap_set_result import JoinedGap
from flex_ident.report.ros_parameters import write_ros_parameters
from flex_ident.report.several_writing import GAPS_PLOT, PLOT


def write_gap_set(
    result: JoinedGap, folder: Path, content: Mapping[str, Any], *, plots: bool = True
) -> dict[str, Path]:
    """Write `content` as gap.json, parameters.yaml, model.yaml, report.html and pictures; what was written, by name.

    Files of another run go; beside identify_bag's result of the same recordings its report.html stays, and this one is
    gap_report.html. Raises UsageError when the folder cannot be written.
    """
    other = stored_content(folder, "result.json")
    stays = other is not None and other.get("bag", {}).get("sha256") == content["bag"]["sha256"]
    report = GAP_REPORT if stays else REPORT
    stale = (*EXPLANATION, GAPS_PLOT, *MODELS, *(() if stays else (*IDENTIFICATION, REPORT, PLOT)))
    with renewed(folder, stale) as aside:
        (aside / "gap.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_ros_parameters(result.joined.model, aside / "parameters.yaml")
        result.joined.model.write(aside / "model.yaml")
        if plots:
            from flex_ident.report.gap_set_report import gap_set_html, gaps_plot
            from flex_ident.report.several_report import recordings_plot

            figures = {"gap_recordings": gaps_plot(result), "recordings": recordings_plot(result.joined)}
            (aside / GAPS_PLOT).write_bytes(figures["gap_recordings"])
            if not stays:
                (aside / PLOT).write_bytes(figures["recordings"])
            (aside / report).write_text(gap_set_html(result, figures), encoding="utf-8")
    names = ("gap.json", *MODELS, *((report,) if plots else ()))
    return {name: folder / name for name in names}
