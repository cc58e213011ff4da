"""One explanation from bag to folder: what the command and the node both do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flex_ident.bags.reading import read_recording
from flex_ident.configuration.settings import Value
from flex_ident.errors import UsageError
from flex_ident.gap import GapExplanation, explain
from flex_ident.gap.units import explanation_in_amperes, prismatic_explanation
from flex_ident.jobs.options import gap_options
from flex_ident.jobs.places import Folder, Place
from flex_ident.jobs.robots import described, description_of
from flex_ident.jobs.signals import signal_selection
from flex_ident.jobs.simulators import BesideSimulator, beside_simulator, simulated_recording
from flex_ident.parameters.current import is_current
from flex_ident.recording import Recording
from flex_ident.report.answers import answer_content, answer_text
from flex_ident.report.folder import beside
from flex_ident.report.gap_result import gap_content
from flex_ident.report.gap_writing import write_explanation

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class FinishedExplanation:
    """An explanation, `gap.json`'s content, the files written, and the comparison with a simulator if one was given.

    `raw` is the explanation before a current's units are written as such.

    `beside_result`: they were written into a folder that holds identify_bag's result of the same recording.
    `unwritten`: why nothing was written.
    """

    explanation: GapExplanation
    raw: GapExplanation
    recording: Recording
    content: dict[str, Any]
    paths: Mapping[str, Path]
    simulator: BesideSimulator
    beside_result: bool = False
    unwritten: UsageError | None = None
    answers: str = ""
    """What the recording can answer, in one line."""


def finished_explanation(
    bag: Path,
    values: Mapping[str, Value],
    place: Place | Folder,
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
) -> FinishedExplanation:
    """Read, explain, write. `read` is told of the recording, `progress` the stage's name and its share done.

    Raises FlexIdentError; before anything is computed where the folder cannot be written, if it is needed.
    """
    options, selection = gap_options(values), signal_selection(values)
    description = description_of(values)
    recording = read_recording(bag, selection, progress=lambda x: progress("reading", x))
    recording = described(recording, description)
    read(recording)
    place = place if isinstance(place, Place) else Place(place)
    folder, unwritten = place.found(recording)
    simulated = simulated_recording(values, selection)
    explanation = explain(recording, options, progress=lambda x, _t: progress("explaining", x))
    shown = [f.effect for f in explanation.findings]
    simulator = beside_simulator(simulated, explanation.final.parameters, shown, options, explanation.sensors)
    if values["prismatic"]:
        explanation = prismatic_explanation(explanation)
    raw = explanation
    if is_current(explanation.final.notices):
        explanation = explanation_in_amperes(explanation)
    content = gap_content(explanation)
    content["answers"] = answer_content(explanation.final, recording)
    content["bag"] = {"path": recording.path, "sha256": recording.sha256}
    content |= simulator.content
    paths: Mapping[str, Path] = {}
    if folder is not None:
        try:
            paths = write_explanation(explanation, recording, folder, content, plots=plots)
        except UsageError as error:
            if place.needed:
                raise
            unwritten = error
    kept = folder is not None and beside(folder, "result.json", recording)
    answers = answer_text(explanation.final, recording)
    return FinishedExplanation(explanation, raw, recording, content, paths, simulator, kept, unwritten, answers)
