"""Damaged and hostile bags, metadata, configurations, models and results: what reading them ends in.

    python bench/fuzz_bags.py [--bags 500] [--files 200] [--identify 0] [--seed 0] [--jobs 2] [--kind TEXT]

Each of `--bags` bags (three storages, their compressions) is mutated and read in a worker with a limit of time and
memory; likewise `--files` files of each other kind. With `--identify N`, N further bags of a virtual joint are
identified as well, and each trusted result is compared with the truth. Counted: exceptions, hangs (over 30 s), memory
(over 1 GiB), silent losses (fewer messages than were recorded, and no notice), errors of more than one printable line,
and trusted parameters more than three standard deviations off. Exit status 1 when there is any. `--only I` repeats one
case, with its traceback; a case is a number that says the same mutation on any machine.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "test" / "bags"))

HANG_S = 30.0
MEMORY_MIB = 1024.0
ADDRESS_SPACE = 6 << 30
SAMPLES = 1500
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
NASTY = [
    "9" * 400, "-" + "9" * 5000, "1e999", ".nan", "-.inf", "!!python/object:os.system x", "*a", "&a [*a]", "{a: {a: ",
    "[" * 2000, "? [", "\0", "\u2028", "'", '"', "<<: *x", "---", "...", "null", "~", "[]", "{}", "true", "0x", "1:1:1",
    "2026-11-26", "!!set {a}", "!!binary aGk=", "|", ">", "#", "\t", "-", "\x1b[2J", "\N{PILE OF POO}", "{" * 500,
    '{"a":' * 3000, "Infinity", "NaN",
]  # fmt: skip


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


def bag_kinds() -> dict[str, Callable[[Path], Path]]:
    """Writers of whole bags, by kind."""
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

    def writer(own: Callable[[Path, list[Any]], Path], store: Any) -> Callable[[Path], Path]:
        return lambda folder: own(folder, messages(store))

    def unfinished(folder: Path, made: list[Any]) -> Path:
        return mcap_file(folder / "bag.mcap", made, CompressionType.NONE, finished=False)

    def unsummed(folder: Path, made: list[Any]) -> Path:
        path = mcap_file(folder / "bag.mcap", made, CompressionType.NONE)
        return without_checksums(path)

    kinds = {name: writer(own, STORE) for name, own in ROS2_KINDS.items()}
    kinds["mcap unfinished"] = writer(unfinished, STORE)
    kinds["mcap without checksums"] = writer(unsummed, STORE)
    kinds |= {name: writer(own, ROS1_STORE) for name, own in ROS1_KINDS.items()}
    return kinds


def without_checksums(path: Path) -> Path:
    """Set the checksum of each chunk to 0, 'not known', as some recorders leave it."""
    data = bytearray(path.read_bytes())
    for at in mcap_records(data):
        if data[at] == 6:
            data[at + 9 + 24 : at + 9 + 28] = bytes(4)
    path.write_bytes(data)
    return path


def mcap_records(data: bytes | bytearray) -> list[int]:
    """Where the records of an MCAP file begin, outside of chunks."""
    places, at = [], 8
    while at + 9 <= len(data) - 8:
        places.append(at)
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return places


def headers(data: bytes) -> list[int]:
    """Bytes that hold the structure of a file of any of the three storages."""
    if data.startswith(b"\x89MCAP0\r\n"):
        outer = mcap_records(data)
        inner = []
        for at in (a for a in outer if data[a] == 6):
            names = int.from_bytes(data[at + 37 : at + 41], "little")
            inside, end = at + 9 + 28 + 4 + names + 8, at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
            while names == 0 and inside + 9 <= end:
                inner.append(inside)
                inside += 9 + int.from_bytes(data[inside + 1 : inside + 9], "little")
        return [*outer, *inner]
    if data.startswith(b"SQLite"):
        return [*range(0, 100, 4), *(p + i for p in range(0, len(data), 4096) for i in (0, 1, 3, 5, 8, 10, 12))]
    found, at = [], data.find(b"op=")
    while at >= 0:
        found += [max(0, at - 8), max(0, at - 4), at + 3]
        at = data.find(b"op=", at + 3)
    return found or [0]


def mutated(data: bytes, random: np.random.Generator) -> tuple[bytes, str]:
    """The bytes, damaged in one of several ways, and its name."""
    new, size = bytearray(data), len(data)
    at = int(random.integers(size))
    length = int(min(size - at, 2 ** random.uniform(0, 15)))
    ways = ("cut", "flip 1", "flip 30", "zeros", "ones", "removed", "twice", "inserted", "moved", "header", "headers",
            "length")  # fmt: skip
    way = str(random.choice(ways))
    if way == "cut":
        del new[max(1, at) :]
    elif way.startswith("flip"):
        for place in random.integers(0, size, int(way.split()[1])):
            new[place] = int(random.integers(256))
    elif way in ("zeros", "ones"):
        new[at : at + length] = bytes([0 if way == "zeros" else 255]) * length
    elif way == "removed":
        del new[at : at + length]
    elif way == "twice":
        new[at:at] = data[at : at + length]
    elif way == "inserted":
        new[at:at] = random.bytes(length)
    elif way == "moved":
        other = int(random.integers(size - length + 1))
        new[other : other + length] = data[at : at + length]
    else:
        places = headers(data)
        for place in random.choice(places, 8 if way == "headers" else 1):
            if way == "length":
                step = [1, 2, 3, 4, 5, 6, 7, 8][int(random.integers(8))]
                value = [0, 1, 9, 0x7F, 0xFF, 31][int(random.integers(6))]
                new[min(size - 1, int(place) + step)] = value
            else:
                new[min(size - 1, int(place) + int(random.integers(4)) * int(random.random() < 0.5))] = int(
                    random.integers(256)
                )
    return bytes(new), way


def mutated_text(text: str, random: np.random.Generator) -> tuple[str, str]:
    """A text, damaged by lines, by characters, or by something nasty in place of a value."""
    lines = text.split("\n")
    way = str(random.choice(["nasty", "nasty", "nasty", "line", "twice", "flip", "indent", "cut"]))
    i = int(random.integers(len(lines)))
    if way == "nasty":
        nasty, head = str(random.choice(NASTY)), lines[i].partition(":")[0]
        lines[i] = f"{head}: {nasty}" if random.random() < 0.6 else nasty if random.random() < 0.5 else nasty + lines[i]
        if lines[i].lstrip().startswith('"'):
            lines[i] += ","
    elif way == "line":
        del lines[i]
    elif way == "twice":
        lines.insert(int(random.integers(len(lines))), lines[i])
    elif way == "indent":
        lines[i] = " " * int(random.integers(8)) + lines[i].lstrip()
    new = "\n".join(lines)
    if way == "flip":
        for _ in range(int(random.integers(1, 12))):
            at = int(random.integers(max(1, len(new))))
            new = new[:at] + chr(int(random.integers(1, 256))) + new[at + 1 :]
    elif way == "cut":
        new = new[: int(random.integers(len(new)))]
    return new, way


def read_bag(bag: Path, outcome: Outcome) -> None:
    from flex_ident.bags import SignalSelection, read_recording
    from flex_ident.report.sentences import sentence

    recording = read_recording(bag, SignalSelection(joint="joint_2"))
    outcome.ending = "read"
    motor = recording.sampling[0]
    outcome.lost = SAMPLES - motor.samples
    outcome.text = "; ".join(sentence(n) for n in recording.notices)
    if outcome.lost > 0 and not recording.notices:
        outcome.faults.append("silent loss")
    if not outcome.text.isprintable():
        outcome.faults.append("not one printable line")


def fuzz_bag(case: int, folder: Path, outcome: Outcome, bases: dict[str, Path]) -> None:
    random = np.random.default_rng([1, case])
    outcome.kind = list(bases)[case % len(bases)]
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


def fuzz_file(case: int, folder: Path, outcome: Outcome) -> None:
    """A configuration, a model or a result, by the case's number."""
    random = np.random.default_rng([2, case])
    outcome.kind = ("configuration", "model", "result")[case % 3]
    file = folder / {"configuration": "a.yaml", "model": "model.yaml", "result": "result.json"}[outcome.kind]
    whole = {"configuration": CONFIGURATION, "model": MODEL, "result": json.dumps(SCHEMA_RESULT, indent=1)}
    text, outcome.mutation = mutated_text(whole[outcome.kind], random)
    file.write_text(text, encoding="utf-8", errors="surrogateescape")
    if outcome.kind == "configuration":
        from flex_ident.configuration import IDENTIFY_SETTINGS, read_settings

        read_settings(file, IDENTIFY_SETTINGS, node="identifier", command="identify_bag")
    elif outcome.kind == "model":
        from flex_ident.parameters import read_joint_model

        read_joint_model(file)
    else:
        from flex_ident.report.stored import stored_result

        stored_result(file)
    outcome.ending = "read"


def fuzz_identification(case: int, folder: Path, outcome: Outcome) -> None:
    """A damaged bag of a virtual joint, identified; trusted parameters must lie within three standard deviations."""
    from flex_ident.bags import SignalSelection, read_recording
    from flex_ident.bags.virtual import write_virtual_bag
    from flex_ident.estimation.identification import identify
    from flex_ident.parameters import JointModel

    random = np.random.default_rng([3, case])
    truth = {"Jm": 1.2, "K": 9000.0, "JL": 2.5, "FVm": 8.0, "FSm": 6.0, "FV": 4.0, "FS": 3.0}
    storage = ("mcap", "sqlite3")[case % 2]
    bag = folder / "bag"
    write_virtual_bag(bag, JointModel(truth, {}, "joint_2"), seed=case, storage=storage)
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
            if off > 3.0:
                outcome.faults.append("trusted and wrong")
                outcome.text += f"{parameter.key} {off:.1f} standard deviations off; "


def run_case(what: str, case: int, bases: dict[str, Path]) -> Outcome:
    """One case, in a folder of its own; whatever escapes is an exception."""
    from flex_ident.errors import FlexIdentError

    outcome = Outcome(case, what, "", "")
    peak_reset()
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="fuzz_") as folder:
        try:
            if what == "bag":
                fuzz_bag(case, Path(folder), outcome, bases)
            elif what == "file":
                fuzz_file(case, Path(folder), outcome)
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


def work(connection: Any, bases: dict[str, Path]) -> None:
    """A worker's loop: cases in, outcomes out. A warning of numpy would reach the user: it is an exception here."""
    warnings.filterwarnings("error", category=RuntimeWarning, module="flex_ident")
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    while True:
        task = connection.recv()
        if task is None:
            return
        connection.send(run_case(*task, bases))


class Worker:
    """A process that runs one case at a time, and is replaced when it hangs or dies."""

    def __init__(self, bases: dict[str, Path]) -> None:
        self._bases = bases
        self.task: tuple[str, int] | None = None
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(theirs, self._bases), daemon=True)
        self._process.start()
        theirs.close()
        self.since = time.monotonic()

    def give(self, task: tuple[str, int]) -> None:
        self.task, self.since = task, time.monotonic()
        self.connection.send(task)

    def taken(self) -> Outcome | None:
        """The outcome, when there is one; a worker that hangs or died gives a fault."""
        what, case = self.task or ("", 0)
        if self.connection.poll():
            try:
                outcome: Outcome = self.connection.recv()
                self.task = None
                return outcome
            except EOFError:
                fault = "killed"
        elif time.monotonic() - self.since > HANG_S * (1.0 if what != "identify" else 20.0):
            fault = "hang"
        else:
            return None
        self._process.kill()
        self._process.join()
        self._start()
        self.task = None
        return Outcome(case, what, "", fault, faults=[fault])

    def end(self) -> None:
        self.connection.send(None)
        self._process.join(5)


def run_all(tasks: list[tuple[str, int]], bases: dict[str, Path], jobs: int) -> list[Outcome]:
    """All outcomes; faults are printed as they are found."""
    workers = [Worker(bases) for _ in range(jobs)]
    outcomes: list[Outcome] = []
    left = tasks[::-1]
    while left or any(w.task for w in workers):
        for worker in workers:
            if worker.task is None and left:
                worker.give(left.pop())
        wait([w.connection for w in workers if w.task], timeout=1.0)
        for worker in workers:
            outcome = worker.taken() if worker.task else None
            if outcome is not None:
                outcomes.append(outcome)
                if outcome.faults:
                    print(
                        f"{', '.join(outcome.faults)}: {outcome.kind}, case {outcome.case} ({outcome.mutation}), "
                        f"{outcome.lost} lost, {outcome.seconds:.1f} s, {outcome.mebibytes:.0f} MiB: "
                        f"{outcome.text.strip().splitlines()[-1:]}",
                        flush=True,
                    )
    for worker in workers:
        worker.end()
    return outcomes


def table(outcomes: list[Outcome]) -> str:
    """Endings and faults of each kind."""
    lines = [
        f"{'kind':28} {'cases':>6} {'read':>6} {'refused':>8} {'loss said':>10} {'slowest':>8} {'largest':>9}  faults"
    ]
    for kind in dict.fromkeys(o.kind for o in sorted(outcomes, key=lambda o: o.kind)):
        own = [o for o in outcomes if o.kind == kind]
        endings = Counter(o.ending for o in own)
        faults = Counter(fault for o in own for fault in o.faults)
        said = sum(o.lost > 0 and not o.faults for o in own)
        lines.append(
            f"{kind:28} {len(own):6} {len(own) - endings['refused'] - endings['exception']:6} {endings['refused']:8} "
            f"{said:10} {max(o.seconds for o in own):6.1f} s {max(o.mebibytes for o in own):5.0f} MiB  "
            f"{', '.join(f'{n} {fault}' for fault, n in faults.items()) or 'none'}"
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bags", type=int, default=500)
    parser.add_argument("--files", type=int, default=200, help="of each other kind")
    parser.add_argument("--identify", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kind", default="", help="only kinds of bags whose name holds this")
    parser.add_argument("--only", metavar="WHAT:CASE", help="bag:7, file:7 or identify:7")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fuzz_bases_") as folder:
        os.environ["TMPDIR"] = folder
        tempfile.tempdir = folder
        bases = {}
        for name, write in bag_kinds().items():
            if given.kind in name:
                place = Path(folder) / name.replace(" ", "_").replace(",", "")
                place.mkdir()
                bases[name] = write(place)
        if given.only:
            what, _, number = given.only.partition(":")
            outcome = run_case(what, int(number), bases)
            print(outcome.text, outcome, sep="\n")
            return int(bool(outcome.faults))
        first = given.seed
        tasks = [("bag", i) for i in range(first, first + given.bags)]
        tasks += [("file", i) for i in range(first, first + 3 * given.files)]
        tasks += [("identify", i) for i in range(first, first + given.identify)]
        started = time.monotonic()
        outcomes = run_all(tasks, bases, given.jobs)
        left = [p.name for p in Path(folder).iterdir() if p.name.startswith(("fuzz_", "flex_ident_"))]
    print(table(outcomes))
    faults = Counter(fault for o in outcomes for fault in o.faults)
    print(
        f"{len(outcomes)} cases in {time.monotonic() - started:.0f} s: {sum(faults.values())} faults "
        f"({', '.join(f'{n} {fault}' for fault, n in faults.items()) or 'none'}); {len(left)} temporary files left"
    )
    return int(bool(faults or left))


if __name__ == "__main__":
    sys.exit(main())
