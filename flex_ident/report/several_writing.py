"""All files of several recordings' result in one folder."""

from __future__ import annotations

import json
from pathlib import Path

from flex_ident.report.folder import EXPLANATION, IDENTIFICATION, MODELS, REPORT, renewed
from flex_ident.report.ros_parameters import write_ros_parameters
from flex_ident.report.several_result import JoinedResult, several_content

PLOT = "recordings.png"


def write_several(joined: JoinedResult, folder: Path, *, plots: bool = True) -> dict[str, Path]:
    """Write result.json, parameters.yaml, model.yaml, report.html and its picture; what was written, by name.

    The files of another run go. Raises UsageError when the folder cannot be written.
    """
    with renewed(folder, (*IDENTIFICATION, REPORT, *MODELS, *EXPLANATION, PLOT)) as aside:
        content = several_content(joined)
        (aside / "result.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_ros_parameters(joined.model, aside / "parameters.yaml")
        joined.model.write(aside / "model.yaml")
        if plots:
            from flex_ident.report.several_report import recordings_plot, several_html

            picture = recordings_plot(joined)
            (aside / PLOT).write_bytes(picture)
            (aside / REPORT).write_text(several_html(joined, {"recordings": picture}), encoding="utf-8")
    names = ("result.json", *MODELS, *((REPORT,) if plots else ()))
    return {name: folder / name for name in names}
