"""One identification from bag to folder: what the command and the node both do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flex_ident.bags.reading import read_recording
from flex_ident.configuration.settings import Value
from flex_ident.errors import UsageError
from flex_ident.estimation.identification import identify
from flex_ident.jobs.options import identify_options
from flex_ident.jobs.places import Folder, Place
from flex_ident.jobs.robots import described, description_of
from flex_ident.jobs.signals import signal_selection
from flex_ident.parameters import Identification
from flex_ident.parameters.current import in_amperes, is_current
from flex_ident.parameters.prismatic import prismatic
from flex_ident.recording import Recording
from flex_ident.report.result import result_content
from flex_ident.report.writing import write_identification

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class FinishedIdentification:
    """A result, the recording it came from, `result.json`'s content, and the files written, or why they were not."""

    result: Identification
    recording: Recording
    content: dict[str, Any]
    paths: Mapping[str, Path]
    unwritten: UsageError | None = None


def finished_identification(
    bag: Path,
    values: Mapping[str, Value],
    place: Place | Folder,
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
    raw_units: bool = False,
) -> FinishedIdentification:
    """Read, identify, write. `read` is told of the recording, `progress` the stage's name and its share done.

    `raw_units`: what is handed back of a current is not turned into units of it; what is written is.
    Raises FlexIdentError; before anything is computed where the folder cannot be written, if it is needed.
    """
    selection, options = signal_selection(values), identify_options(values)
    description = description_of(values)
    recording = read_recording(bag, selection, progress=lambda x: progress("reading", x))
    recording = described(recording, description)
    read(recording)
    place = place if isinstance(place, Place) else Place(place)
    folder, unwritten = place.found(recording)
    result = identify(
        recording, options, prismatic=bool(values["prismatic"]), progress=lambda x: progress("identifying", x)
    )
    if values["prismatic"]:
        result = prismatic(result)
    shown = in_amperes(result) if is_current(result.notices) else result
    progress("writing", 0.0)
    paths: Mapping[str, Path] = {}
    if folder is not None:
        try:
            paths = write_identification(shown, recording, folder, plots=plots)
        except UsageError as error:
            if place.needed:
                raise
            unwritten = error
    progress("writing", 1.0)
    content = result_content(shown, recording)
    return FinishedIdentification(result if raw_units else shown, recording, content, paths, unwritten)
