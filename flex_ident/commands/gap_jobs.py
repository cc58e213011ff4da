"""One explanation from bag to files: what the command and the node both do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flex_ident.bags import read_recording
from flex_ident.commands.options import given_model, signal_selection
from flex_ident.configuration.settings import Value
from flex_ident.gap import GapExplanation, GapOptions, explain
from flex_ident.gap.prismatic import prismatic_explanation
from flex_ident.gap.simulator import SimulatorGap, compared_with_simulator, simulator_content
from flex_ident.recording import Recording
from flex_ident.report.gap_result import gap_content
from flex_ident.report.gap_writing import write_explanation

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class FinishedExplanation:
    """An explanation, `gap.json`'s content, the files written, and the comparison with a simulator if one was given.

    `beside_result`: they were written into a folder that holds a result of identify_bag.
    """

    explanation: GapExplanation
    content: dict[str, Any]
    paths: Mapping[str, Path]
    simulator: SimulatorGap | None = None
    beside_result: bool = False


def names_in(text: object) -> tuple[str, ...]:
    """The names of a comma-separated list."""
    return tuple(n.strip() for n in str(text).split(",") if n.strip())


def gap_options(values: Mapping[str, Value]) -> GapOptions:
    """How to search. Raises UsageError and ConfigurationError."""
    return GapOptions(
        sensors=str(values["sensors"]),
        rigid=bool(values["rigid"]),
        without=names_in(values["without"]),
        effects=names_in(values["effects"]),
        add=names_in(values["add"]),
        model=given_model(values),
        first_mode_hz=float(values["first_mode_hz"]) or None,
        prismatic=bool(values["prismatic"]),
    )


def finished_explanation(
    bag: Path,
    values: Mapping[str, Value],
    folder: Callable[[str], Path | None],
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
) -> FinishedExplanation:
    """Read, explain, write. `folder` gives the output folder for a joint, None for none. Raises FlexIdentError."""
    options, selection = gap_options(values), signal_selection(values)
    recording = read_recording(bag, selection, progress=lambda x: progress("reading", x))
    read(recording)
    compared: SimulatorGap | None = None
    if values["simulated"]:
        # A simulator speaks SI on the link side, whatever the robot's driver does.
        own = replace(selection, effort_scale=1.0, gear_ratio=1.0)
        simulated = read_recording(Path(str(values["simulated"])).expanduser(), own)
        compared = compared_with_simulator(
            recording, simulated, options, progress=lambda x, _t: progress("explaining", x)
        )
        explanation = compared.explanation
    else:
        explanation = explain(recording, options, progress=lambda x, _t: progress("explaining", x))
    if values["prismatic"]:
        explanation = prismatic_explanation(explanation)
    content = gap_content(explanation)
    content["bag"] = {"path": recording.path, "sha256": recording.sha256}
    if compared is not None:
        content["simulated"] = simulator_content(compared)
    place = folder(recording.joint)
    paths = {} if place is None else write_explanation(explanation, recording, place, content, plots=plots)
    beside = place is not None and (place / "result.json").exists()
    return FinishedExplanation(explanation, content, paths, compared, beside)
