"""All files of several recordings' result in one folder."""

from __future__ import annotations

import json
from pathlib import Path

from flex_ident.report.folder import EXPLANATION, GAP_REPORT, IDENTIFICATION, MODELS, REPORT, renewed, stored_content
from flex_ident.report.ros_parameters import write_ros_parameters
from flex_ident.report.several_result import JoinedResult, several_content

PLOT = "recordings.png"
GAPS_PLOT = "gap_recordings.png"
"""Of an explanation of the same recordings."""


def write_several(joined: JoinedResult, folder: Path, *, plots: bool = True) -> dict[str, Path]:
    """Write result.json, parameters.yaml, model.yaml, report.html and its picture; what was written, by name.

    The files of another run go; an explanation of the same recordings stays, its report.html as gap_report.html.
    Raises UsageError when the folder cannot be written.
    """
    content = several_content(joined)
    other = stored_content(folder, "gap.json")
    stays = other is not None and other.get("bag", {}).get("sha256") == content["bag"]["sha256"]
    gap_alone = stays and not (folder / "result.json").exists() and (folder / REPORT).exists()
    stale = (*IDENTIFICATION, REPORT, *MODELS, PLOT, *(() if stays else (*EXPLANATION, GAPS_PLOT)))
    with renewed(folder, stale) as aside:
        (aside / "result.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_ros_parameters(joined.model, aside / "parameters.yaml")
        joined.model.write(aside / "model.yaml")
        if plots:
            from flex_ident.report.several_report import recordings_plot, several_html

            picture = recordings_plot(joined)
            (aside / PLOT).write_bytes(picture)
            (aside / REPORT).write_text(several_html(joined, {"recordings": picture}), encoding="utf-8")
        if gap_alone:
            (aside / GAP_REPORT).write_bytes((folder / REPORT).read_bytes())
    names = ("result.json", *MODELS, *((REPORT,) if plots else ()))
    return {name: folder / name for name in names}
