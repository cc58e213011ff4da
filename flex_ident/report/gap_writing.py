"""All files of an explained gap in one folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flex_ident.gap.explanation import GapExplanation
from flex_ident.recording import Recording
from flex_ident.report.ros_parameters import write_ros_parameters
from flex_ident.report.writing import GAP_REPORT, made_folder


def write_explanation(
    explanation: GapExplanation, recording: Recording, folder: Path, content: Mapping[str, Any], *, plots: bool = True
) -> dict[str, Path]:
    """Write `content` as gap.json, parameters.yaml, model.yaml, report.html and the plots; what was written, by name.

    In the folder of an identification (`result.json`) its report.html stays, and this one is gap_report.html.
    """
    made_folder(folder)
    paths = {name: folder / name for name in ("gap.json", "parameters.yaml", "model.yaml")}
    paths["gap.json"].write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    write_ros_parameters(explanation.final.model, paths["parameters.yaml"])
    explanation.final.model.write(paths["model.yaml"])
    if plots:
        from flex_ident.report.figures import write_pngs
        from flex_ident.report.gap_plots import gap_figures
        from flex_ident.report.gap_report import gap_html

        figures = gap_figures(explanation)
        write_pngs(figures, folder)
        name = GAP_REPORT if (folder / "result.json").exists() else "report.html"
        paths[name] = folder / name
        paths[name].write_text(gap_html(explanation, recording, figures), encoding="utf-8")
    return paths
