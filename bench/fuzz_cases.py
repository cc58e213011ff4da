"""The cases of `fuzz_bags.py`: what is written, damaged and read, by a number that says the same on any machine."""

from __future__ import annotations

import json
import math
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from fuzz_mutations import NASTY, NASTY_XML, mcap_records, mutated, mutated_content, mutated_text
from fuzz_tables import KINDS, damaged

from flex_ident.errors import FlexIdentError

TESTS = Path(__file__).resolve().parent.parent / "test"
sys.path[:0] = [str(TESTS / "bags"), str(TESTS / "plants")]

FOXGLOVE = "mcap of "
"""What the kinds of bags begin with whose messages are Foxglove's."""
MEMORY_MIB = 1024.0
SAMPLES = 1500
CONTENT_SHARE = 0.2
"""Share of the bags that are whole, and say what no robot would."""
SCHEMA_RESULT = {
    "schema": "flex_ident/result/1", "joint": "joint_2", "sensors": "motor", "method": "auto", "verdict": "trusted",
    "bag": {"path": "bag", "sha256": "0" * 64}, "warnings": [],
    "parameters": {
        key: {"value": 1.5, "std": 0.1, "ci95": [1.3, 1.7], "relative_std_percent": 6.7, "unit": "1",
              "identifiable": True} for key in ("Jm", "K", "JL")
    },
}  # fmt: skip
MODEL = (
    "schema: flex_ident/model/1\njoint: joint_2\nparameters:\n  Jm: 1.0\n  K: 20000.0\n  JL: 2.5\n  FV: 1.0e+1\n"
    "effects:\n  backlash:\n    gap: 0.0008\n  stribeck_friction: {amplitude: 3.0, velocity: 0.1}\n"
)
CONFIGURATION = (
    "/**:\n  ros__parameters:\n    joint: joint_2\n    effort_scale: 1.5\n    sensors: motor\n    rigid: false\n"
    "identifier:\n  ros__parameters: {first_mode_hz: 12.5, motor_position: '/joint_states:a.position'}\n"
)
URDF = """<?xml version="1.0"?>
<robot name="r">
  <link name="a"/>
  <joint name="joint_1" type="continuous"><limit effort="10" velocity="2"/></joint>
  <joint name="joint_2" type="revolute">
    <parent link="a"/>
    <limit lower="-1.5" upper="1.5" velocity="2.0" effort="60"/>
    <safety_controller soft_lower_limit="-1.4" soft_upper_limit="1.4" k_velocity="1"/>
  </joint>
  <ros2_control name="c" type="system">
    <joint name="joint_2"><command_interface name="position"/><state_interface name="position"/></joint>
  </ros2_control>
</robot>
"""
FILES = {
    "configuration": "a.yaml", "model": "model.yaml", "result": "result.json", "urdf": "robot.urdf",
    "metadata": "metadata.yaml",
}  # fmt: skip
OTHERS = (*FILES, *KINDS)
"""Kinds of files that are no bags, in turn by the number of the case."""


@dataclass
class Outcome:
    """What one case ended in."""

    case: int
    kind: str
    mutation: str
    ending: str
    text: str = ""
    seconds: float = 0.0
    mebibytes: float = 0.0
    lost: int = 0
    faults: list[str] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    """Errors of trusted parameters, in standard deviations."""


def bag_kinds(random: np.random.Generator | None = None) -> dict[str, Callable[[Path], tuple[Path, str]]]:
    """Writers of whole bags, by kind, and of what their messages say that none should where `random` is given."""
    from bag_writer import RATE_HZ, ROS1_KINDS, ROS1_STORE, ROS2_KINDS, STORE, Message, mcap_file, ns, swing
    from mcap.writer import CompressionType

    def messages(store: Any) -> list[Any]:
        made = swing(SAMPLES, store=store)
        kind = store.types["std_msgs/msg/Float64MultiArray"]
        layout = store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
        others = [
            Message("/other", ns(i * 5 / RATE_HZ), "std_msgs/msg/Float64MultiArray", kind(layout, np.full(3, float(i))))
            for i in range(SAMPLES // 5)
        ]
        return sorted([*made, *others], key=lambda m: m.received_ns)

    def writer(own: Callable[[Path, list[Any]], Path], store: Any) -> Callable[[Path], tuple[Path, str]]:
        def write(folder: Path) -> tuple[Path, str]:
            made, way = messages(store), ""
            if random is not None:
                made, way = mutated_content(made, random)
            return own(folder, made), way

        return write

    def unfinished(folder: Path, made: list[Any]) -> Path:
        return mcap_file(folder / "bag.mcap", made, CompressionType.NONE, finished=False)

    def unsummed(folder: Path, made: list[Any]) -> Path:
        path = mcap_file(folder / "bag.mcap", made, CompressionType.NONE)
        return without_checksums(path)

    def foxglove(encoding: str) -> Callable[[Path], tuple[Path, str]]:
        return lambda folder: (foxglove_bag(folder / "bag.mcap", encoding), "")

    kinds = {name: writer(own, STORE) for name, own in ROS2_KINDS.items()}
    if random is None:
        kinds |= {f"{FOXGLOVE}{encoding}": foxglove(encoding) for encoding in ("json", "protobuf")}
    kinds["mcap unfinished"] = writer(unfinished, STORE)
    kinds["mcap without checksums"] = writer(unsummed, STORE)
    kinds |= {name: writer(own, ROS1_STORE) for name, own in ROS1_KINDS.items()}
    return kinds


def foxglove_bag(path: Path, encoding: str) -> Path:
    """Joint states as Foxglove's tools write them, of which damage reaches the messages."""
    from mcap.writer import CompressionType
    from test_foxglove import foxglove, joint_states_proto, mcap_of, protobuf_rows

    if encoding == "json":
        rows = [json.dumps(foxglove(i)).encode() for i in range(SAMPLES)]
        schema = ("foxglove.JointStates", "jsonschema", b"{}")
    else:
        kind, descriptors = joint_states_proto()
        rows, schema = protobuf_rows(kind), ("foxglove.JointStates", "protobuf", descriptors)
    mcap_of(path, "/joint_states", encoding, schema, rows, compression=CompressionType.NONE)
    return without_checksums(path)


def without_checksums(path: Path) -> Path:
    """Set the checksum of each chunk to 0, 'not known', as some recorders leave it."""
    data = bytearray(path.read_bytes())
    for at in mcap_records(data):
        if data[at] == 6:
            data[at + 9 + 24 : at + 9 + 28] = bytes(4)
    path.write_bytes(data)
    return path


def read_bag(bag: Path, outcome: Outcome, *, whole: bool = True) -> None:
    """Read one; where the messages' contents are `whole`, each that is missing must be said."""
    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection
    from flex_ident.report.sentences import sentence

    recording = read_recording(bag, SignalSelection(joint="joint_2"))
    outcome.ending = "read"
    motor = recording.sampling[0]
    outcome.lost = SAMPLES - motor.samples
    outcome.text = "; ".join(sentence(n) for n in recording.notices)
    if whole and outcome.lost > 0 and not recording.notices:
        outcome.faults.append("silent loss")
    if not outcome.text.isprintable():
        outcome.faults.append("not one printable line")


def fuzz_bag(case: int, folder: Path, outcome: Outcome, bases: dict[str, Path]) -> None:
    random = np.random.default_rng([1, case])
    outcome.kind = list(bases)[case % len(bases)]
    if random.random() < CONTENT_SHARE and not outcome.kind.startswith(FOXGLOVE):
        bag, outcome.mutation = bag_kinds(random)[outcome.kind](folder)
        read_bag(bag, outcome, whole=False)
        return
    base = bases[outcome.kind]
    bag = folder / base.name
    if base.is_dir():
        shutil.copytree(base, bag)
    else:
        shutil.copy(base, bag)
    file = next(p for p in sorted(bag.iterdir()) if p.name != "metadata.yaml") if bag.is_dir() else bag
    metadata = bag / "metadata.yaml"
    what = random.random()
    if bag.is_dir() and what < 0.15:
        text, outcome.mutation = mutated_text(metadata.read_text(), random)
        metadata.write_text(text, encoding="utf-8", errors="surrogateescape")
        outcome.mutation = f"metadata {outcome.mutation}"
    else:
        data, outcome.mutation = mutated(file.read_bytes(), random)
        file.write_bytes(data)
        if bag.is_dir() and what > 0.7:
            metadata.unlink()
            outcome.mutation += ", no metadata"
    read_bag(bag, outcome)


def fuzz_file(case: int, folder: Path, outcome: Outcome, bases: dict[str, Path]) -> None:
    """A file of another kind, by the case's number."""
    random = np.random.default_rng([2, case])
    outcome.kind = OTHERS[case % len(OTHERS)]
    if outcome.kind in KINDS:
        outcome.mutation = damaged(outcome.kind, folder, random)
        outcome.ending = "read"
        return
    file, nasty = folder / FILES[outcome.kind], NASTY
    if outcome.kind == "metadata":
        folders = [b for b in bases.values() if b.is_dir()]
        bag = Path(shutil.copytree(folders[case // len(OTHERS) % len(folders)], folder / "bag"))
        file = bag / FILES[outcome.kind]
        whole = file.read_text()
    elif outcome.kind == "urdf":
        whole, nasty = URDF, NASTY_XML
    else:
        texts = {"configuration": CONFIGURATION, "model": MODEL, "result": json.dumps(SCHEMA_RESULT, indent=1)}
        whole = texts[outcome.kind]
    text, outcome.mutation = mutated_text(whole, random, nasty)
    file.write_text(text, encoding="utf-8", errors="surrogatepass" if outcome.kind == "urdf" else "surrogateescape")
    if outcome.kind == "metadata":
        read_bag(bag, outcome)
    else:
        read_file(outcome.kind, file, text)
    outcome.ending = "read"


def read_file(kind: str, file: Path, text: str) -> None:
    """Read a file of this kind by all that reads it."""
    from flex_ident.configuration import IDENTIFY_SETTINGS, read_settings
    from flex_ident.excitation.limits import is_continuous, urdf_limits
    from flex_ident.parameters import read_joint_model
    from flex_ident.report.comparison import compared
    from flex_ident.report.export import exported
    from flex_ident.report.export.formats import FORMATS
    from flex_ident.report.stored import stored_result

    if kind == "configuration":
        read_settings(file, IDENTIFY_SETTINGS, node="identifier", command="identify_bag")
    elif kind == "model":
        read_joint_model(file)
    elif kind == "urdf":
        urdf_limits(text, "joint_2")
        is_continuous(text, "joint_2")
    else:
        stored_result(file)
        compared([file, file])
        for name in FORMATS:
            with suppress(FlexIdentError):
                exported(file, name)


def fuzz_identification(case: int, folder: Path, outcome: Outcome) -> None:
    """A damaged bag of a virtual joint, identified; trusted parameters must lie within three standard deviations."""
    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection
    from flex_ident.bags.virtual import write_virtual_bag
    from flex_ident.estimation.identification import identify
    from flex_ident.parameters import JointModel
    from flex_ident.virtual_joint import Experiment

    random = np.random.default_rng([3, case])
    truth = {"Jm": 1.2, "K": 9000.0, "JL": 2.5, "FVm": 8.0, "FSm": 6.0, "FV": 4.0, "FS": 3.0}
    storage = ("mcap", "sqlite3")[case % 2]
    bag = folder / "bag"
    experiment = Experiment(duration_s=12.0, sample_rate_hz=500.0)
    write_virtual_bag(bag, JointModel(truth, {}, "joint_2"), experiment, seed=case, storage=storage)
    outcome.kind = f"identified {storage}"
    file = next(p for p in sorted(bag.iterdir()) if p.name != "metadata.yaml")
    data, outcome.mutation = mutated(file.read_bytes(), random)
    file.write_bytes(data)
    result = identify(read_recording(bag, SignalSelection(joint="joint_2")))
    outcome.ending = result.verdict
    if result.verdict != "trusted":
        return
    for parameter in result.parameters:
        if parameter.identifiable and parameter.key in truth and math.isfinite(parameter.std) and parameter.std > 0.0:
            off = abs(parameter.value - truth[parameter.key]) / parameter.std
            outcome.off.append(off)
            if off > 3.0:
                outcome.faults.append("trusted and wrong")
                outcome.text += f"{parameter.key} {off:.1f} standard deviations off; "


def run_case(what: str, case: int, bases: dict[str, Path]) -> Outcome:
    """One case, in a folder of its own; whatever escapes is an exception."""
    outcome = Outcome(case, what, "", "")
    peak_reset()
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="fuzz_") as folder:
        try:
            if what == "bag":
                fuzz_bag(case, Path(folder), outcome, bases)
            elif what == "file":
                fuzz_file(case, Path(folder), outcome, bases)
            else:
                fuzz_identification(case, Path(folder), outcome)
        except FlexIdentError as error:
            outcome.ending, outcome.text = "refused", str(error)
            if not str(error).isprintable():
                outcome.faults.append("not one printable line")
        except Exception:
            outcome.ending, outcome.text = "exception", traceback.format_exc()
            outcome.faults.append("exception")
    outcome.seconds = time.perf_counter() - started
    outcome.mebibytes = peak_mebibytes()
    if outcome.mebibytes > MEMORY_MIB:
        outcome.faults.append("memory")
    return outcome


def peak_reset() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def peak_mebibytes() -> float:
    line = next(s for s in Path("/proc/self/status").read_text().splitlines() if s.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0
