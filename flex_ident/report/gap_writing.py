"""All files of an explained gap in one folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flex_ident.gap.explanation import GapExplanation
from flex_ident.recording import Recording
from flex_ident.report.folder import EXPLANATION, GAP_REPORT, IDENTIFICATION, MODELS, REPORT, beside, renewed
from flex_ident.report.ros_parameters import write_ros_parameters


def write_explanation(
    explanation: GapExplanation, recording: Recording, folder: Path, content: Mapping[str, Any], *, plots: bool = True
) -> dict[str, Path]:
    """Write `content` as gap.json, parameters.yaml, model.yaml, report.html and the plots; what was written, by name.

    Of what is there, the files of another run go; beside an identification of the same recording (`result.json`), its
    report.html stays, and this one is gap_report.html. Raises UsageError when the folder cannot be written.
    """
    result_stays = beside(folder, "result.json", recording)
    report = GAP_REPORT if result_stays else REPORT
    stale = (*EXPLANATION, *MODELS, *(() if result_stays else (*IDENTIFICATION, REPORT)))
    with renewed(folder, stale) as aside:
        (aside / "gap.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_ros_parameters(explanation.final.model, aside / "parameters.yaml")
        explanation.final.model.write(aside / "model.yaml")
        if plots:
            from flex_ident.report.figures import write_pngs
            from flex_ident.report.gap_plots import gap_figures
            from flex_ident.report.gap_report import gap_html

            figures = gap_figures(explanation)
            write_pngs(figures, aside)
            (aside / report).write_text(gap_html(explanation, recording, figures), encoding="utf-8")
    names = ("gap.json", *MODELS, *((report,) if plots else ()))
    return {name: folder / name for name in names}
