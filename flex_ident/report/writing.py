"""All files of a result in one folder."""

from __future__ import annotations

import json
from pathlib import Path

from flex_ident.errors import UsageError
from flex_ident.parameters import Identification
from flex_ident.recording import Recording
from flex_ident.report.result import result_content
from flex_ident.report.ros_parameters import write_ros_parameters

GAP_REPORT = "gap_report.html"
"""The report of `explain_gap` in a folder that holds that of `identify_bag` as well."""


def made_folder(folder: Path) -> Path:
    """The folder, made if missing. Raises UsageError when that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".flex_ident"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UsageError(f"--out {folder}: cannot be written ({error.strerror}).") from error
    return folder


def write_identification(
    result: Identification, recording: Recording, folder: Path, *, plots: bool = True
) -> dict[str, Path]:
    """Write result.json, parameters.yaml, model.yaml, report.html and the plots; what was written, by name.

    The report.html of an explained gap that was there first is kept as gap_report.html.
    """
    made_folder(folder)
    report = folder / "report.html"
    if report.exists() and (folder / "gap.json").exists() and not (folder / "result.json").exists():
        report.replace(folder / GAP_REPORT)
    paths = {name: folder / name for name in ("result.json", "parameters.yaml", "model.yaml")}
    content = result_content(result, recording)
    paths["result.json"].write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    write_ros_parameters(result.model, paths["parameters.yaml"])
    result.model.write(paths["model.yaml"])
    if plots:
        from flex_ident.report.figures import write_pngs
        from flex_ident.report.identification_plots import identification_figures
        from flex_ident.report.identification_report import report_html

        figures = identification_figures(result, recording)
        write_pngs(figures, folder)
        paths["report.html"] = folder / "report.html"
        paths["report.html"].write_text(report_html(result, recording, figures), encoding="utf-8")
    return paths
