"""All files of a result in one folder."""

from __future__ import annotations

import json
from pathlib import Path

from flex_ident.parameters import Identification
from flex_ident.recording import Recording
from flex_ident.report.folder import EXPLANATION, GAP_REPORT, IDENTIFICATION, MODELS, REPORT, beside, renewed
from flex_ident.report.result import result_content
from flex_ident.report.ros_parameters import write_ros_parameters


def write_identification(
    result: Identification, recording: Recording, folder: Path, *, plots: bool = True
) -> dict[str, Path]:
    """Write result.json, parameters.yaml, model.yaml, report.html and the plots; what was written, by name.

    Of what is there, the files of another run go; an explanation of the same recording stays, its report.html as
    gap_report.html. Raises UsageError when the folder cannot be written.
    """
    gap_stays = beside(folder, "gap.json", recording)
    gap_alone = gap_stays and not (folder / "result.json").exists() and (folder / REPORT).exists()
    stale = (*IDENTIFICATION, REPORT, *MODELS, *(() if gap_stays else EXPLANATION))
    with renewed(folder, stale) as aside:
        content = result_content(result, recording)
        (aside / "result.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_ros_parameters(result.model, aside / "parameters.yaml")
        result.model.write(aside / "model.yaml")
        if plots:
            from flex_ident.report.figures import write_pngs
            from flex_ident.report.identification_plots import identification_figures
            from flex_ident.report.identification_report import report_html

            figures = identification_figures(result, recording)
            write_pngs(figures, aside)
            (aside / REPORT).write_text(report_html(result, recording, figures), encoding="utf-8")
        if gap_alone:
            (aside / GAP_REPORT).write_bytes((folder / REPORT).read_bytes())
    names = ("result.json", *MODELS, *((REPORT,) if plots else ()))
    return {name: folder / name for name in names}
