"""Recordings with the faults of what robots publish: is the fault named, and does what is trusted hold?

    python bench/faulty_recordings.py --joints cobot,harmonic_drive --out faulty.jsonl
    python bench/faulty_recordings.py --faults held_effort,link_drift --strengths 2,4 --out faulty.jsonl
    python bench/faulty_recordings.py --runs 0 --out faulty.jsonl          # the tables of a file, and nothing else

A joint of `bench/plants` is moved along a chirp, its messages get the fault (`bench/faults.py`), are written as a bag
and identified from it. Each is one line of FILE; what is there is not made again. The strengths are numbered 0 to 4.
Columns: how many were trusted; named; and lie, that is, are trusted and more than three of their own standard
deviations off in Jm, K or JL. `named` counts the doubtful and trusted alone: an error that refuses names itself.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from coverage_tables import table  # noqa: E402
from faults import FAULTS, Played, Told, told  # noqa: E402
from plants import Case, made  # noqa: E402
from plants.joints import SIZES  # noqa: E402

Line = dict[str, Any]
RATE_HZ = 500.0
EPOCH_NS = 1_700_000_000_000_000_000
MAIN = ("Jm", "K", "JL")
FAR = 3.0


def case_of_joint(joint: str, seed: int) -> Case:
    """A clean recording of a joint in a plain position loop."""
    return Case(seed, 0, joint, "p_pi", "log_chirp", RATE_HZ, 2, True, "coulomb_stepping", "mean")


def played_of(case: Case, *, link: bool) -> tuple[Played, dict[str, float]]:
    """The messages of a case, and its truth."""
    own = made(case)
    r, rng = own.recorded, case.generator(7)
    t = np.arange(r.motor_position.size) / r.rate_hz
    joint = told(t, r.motor_position, r.motor_torque, rng)
    beside = told(t, r.link_position, np.zeros(t.size), rng) if link else None
    locked, free = own.joint.locked_hz(), own.joint.free_hz()
    low, high = 0.012 * locked, min(2.0 * free, 0.28 * case.rate_hz)
    frequency = low * (high / low) ** (t / case.duration_s)
    return Played(joint, beside, case.rate_hz, frequency, locked, SIZES[case.joint].gear), own.truth


def write_bag(path: Path, played: Played) -> None:
    """The messages as a rosbag2."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    types: Any = store.types
    kind = "sensor_msgs/msg/JointState"
    stamped, header, message = (
        types[k] for k in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", kind)
    )  # fmt: skip

    def rows(topic: str, of: Told, effort: bool) -> list[tuple[int, str, bytes]]:
        found = []
        for i in range(of.stamp.size):
            ns = EPOCH_NS + round(of.stamp[i] * 1e9)
            head = header(stamp=stamped(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="")
            efforts = np.array([of.effort[i]] if effort else [])
            said = message(header=head, name=[("joint", "other")[of.name[i]]], position=np.array([of.position[i]]),
                           velocity=np.zeros(0), effort=efforts)  # fmt: skip
            found.append((EPOCH_NS + round(of.received[i] * 1e9), topic, bytes(store.serialize_cdr(said, kind))))
        return found

    every = rows("/joint_states", played.joint, True)
    if played.link is not None:
        every += rows("/link_joint_states", played.link, False)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        channels = {topic: writer.add_connection(topic, kind, typestore=store) for topic in {r[1] for r in every}}
        for ns, topic, data in sorted(every, key=lambda r: r[0]):
            writer.write(channels[topic], ns, data)


def result_line(name: str, joint: str, fault: str, index: int, seed: int) -> Line:
    """One faulty recording identified; an exception is a result too."""
    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection
    from flex_ident.errors import FlexIdentError
    from flex_ident.estimation.identification import identify

    link = joint != "series_elastic" or (fault in FAULTS and FAULTS[fault].link)
    played, truth = played_of(case_of_joint(joint, seed), link=link)
    strength = 0.0
    if fault != "none":
        kind = FAULTS[fault]
        strength = kind.strengths[index]
        played = kind.fault(played, strength, np.random.default_rng((seed, index, len(fault))))
    line: Line = {"name": name, "joint": joint, "fault": fault, "index": index, "strength": strength, "truth": truth}
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="faulty_") as folder:
        try:
            write_bag(Path(folder) / "bag", played)
            result = identify(read_recording(Path(folder) / "bag", SignalSelection(joint="joint")))
        except FlexIdentError as error:
            return {**line, "verdict": "refused", "error": str(error), "seconds": time.monotonic() - started}
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
            return {**line, "verdict": "error", "error": said, "seconds": time.monotonic() - started}
    line["verdict"] = str(result.verdict)
    line["notices"] = [[str(n.code), n.subject, dict(n.numbers)] for n in result.notices]
    line["pulls"] = {
        p.key: (float(p.value) - truth[p.key]) / float(p.std)
        for p in result.parameters
        if p.key in truth and p.identifiable and 0.0 < p.std < math.inf
    }
    line["off_percent"] = {
        p.key: 100.0 * (float(p.value) / truth[p.key] - 1.0) for p in result.parameters if truth.get(p.key)
    }
    return {**line, "seconds": time.monotonic() - started}


def worst(line: Line) -> float:
    """The largest pull of the essential parameters."""
    return max((abs(line["pulls"][k]) for k in MAIN if k in line.get("pulls", {})), default=0.0)


def is_named(line: Line) -> bool:
    """Whether a code names the fault, or the refusal does."""
    if line["verdict"] == "refused":
        return True
    return any(code in FAULTS[line["fault"]].names for code, _, _ in line.get("notices", []))


def print_tables(lines: list[Line]) -> None:
    """One row a fault; then each that lies or went wrong."""
    rows = []
    for fault in ("none", *FAULTS):
        own = [line for line in lines if line["fault"] == fault]
        if not own:
            continue
        trusted = [line for line in own if line["verdict"] == "trusted"]
        named = "-" if fault == "none" or not FAULTS[fault].names else str(sum(is_named(line) for line in own))
        lies = sum(worst(line) > FAR for line in trusted)
        beyond = max((worst(line) for line in trusted), default=0.0)
        others = [sum(line["verdict"] == v for line in own) for v in ("doubtful", "rejected", "refused", "error")]
        rows.append((fault, len(own), len(trusted), *others, named, lies, f"{beyond:.1f}"))
    header = ("fault", "runs", "trusted", "doubtful", "rejected", "refused", "error", "named", "lie", "worst trusted")
    print(table(header, rows))
    for line in lines:
        unnamed = line["fault"] in FAULTS and FAULTS[line["fault"]].names and not is_named(line)
        if line["verdict"] == "error" or (line["verdict"] == "trusted" and worst(line) > FAR) or unnamed:
            codes = ",".join(code for code, _, _ in line.get("notices", []))
            print(f"{line['joint']} {line['fault']} {line['strength']:g}: {line['verdict']} "
                  f"{worst(line):.1f} [{codes}] {line.get('error', '')}")  # fmt: skip


def main() -> None:
    """Make what is missing, then print the tables of all lines of the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--joints", default="cobot,harmonic_drive,series_elastic")
    parser.add_argument("--faults", default=",".join(("none", *FAULTS)))
    parser.add_argument("--strengths", default="0,1,2,3,4")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=10_000, help="make no more than so many")
    parser.add_argument("--out", type=Path, default=Path("faulty.jsonl"))
    given = parser.parse_args()
    lines = [json.loads(text) for text in given.out.read_text().splitlines()] if given.out.exists() else []
    there = {line["name"] for line in lines}
    wanted = []
    for index in map(int, given.strengths.split(",")):
        for fault in given.faults.split(","):
            for joint in given.joints.split(","):
                at = 0 if fault == "none" else index
                name = f"{given.seed}|{joint}|{fault}|{at}"
                if name not in there:
                    there.add(name)
                    wanted.append((name, joint, fault, at, given.seed))
    with given.out.open("a") as file:
        for done, task in enumerate(wanted[: given.runs], 1):
            line = result_line(*task)
            lines.append(line)
            file.write(json.dumps(line) + "\n")
            file.flush()
            what = f"{line['verdict']} {worst(line):.1f} {line['seconds']:.1f} s"
            print(f"{done}/{len(wanted)} {task[0]} {what}", file=sys.stderr)
    print_tables(lines)


if __name__ == "__main__":
    main()
