"""One identification from bag to files: what the command and the node both do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flex_ident.bags import read_recording
from flex_ident.commands.options import identify_options, signal_selection
from flex_ident.configuration.settings import Value
from flex_ident.estimation.identification import identify
from flex_ident.parameters import Identification
from flex_ident.parameters.prismatic import prismatic
from flex_ident.recording import Recording
from flex_ident.report.result import result_content
from flex_ident.report.writing import write_identification

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class FinishedIdentification:
    """A result, the recording it came from, `result.json`'s content, and the files written."""

    result: Identification
    recording: Recording
    content: dict[str, Any]
    paths: Mapping[str, Path]


def finished_identification(
    bag: Path,
    values: Mapping[str, Value],
    folder: Callable[[str], Path | None],
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
) -> FinishedIdentification:
    """Read, identify, write. `folder` gives the output folder for a joint, None for none; `read` is told of
    the recording.

    Raises FlexIdentError. `progress` takes the stage's name and its share done.
    """
    selection, options = signal_selection(values), identify_options(values)
    recording = read_recording(bag, selection, progress=lambda x: progress("reading", x))
    read(recording)
    result = identify(
        recording, options, prismatic=bool(values["prismatic"]), progress=lambda x: progress("identifying", x)
    )
    if values["prismatic"]:
        result = prismatic(result)
    progress("writing", 0.0)
    place = folder(recording.joint)
    paths = {} if place is None else write_identification(result, recording, place, plots=plots)
    progress("writing", 1.0)
    return FinishedIdentification(result, recording, result_content(result, recording), paths)
