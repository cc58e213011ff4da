"""Hidden effects, named or not: python bench/confusion.py --draws 3 --joints paper,cobot --sensors motor+link,motor

Each draw hides one effect of a random size (`hidden_effects.py`), or two with `--pairs`, in a joint that shares nothing
with the estimator's simulation (`hidden_plant.py`, or MuJoCo with `--plant mujoco`), records it with noise and
quantised encoders, and asks `explain`. Prints the confusion matrix in short and the rates. `--out FILE` keeps every
draw as a line of JSON and skips the draws that FILE already holds.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import statistics
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from hidden_effects import CLASSES, NEEDS_LINK, NONE, OUTSIDE, hidden_effect
from hidden_plant import Noise, hidden_recording, scales_of

from flex_ident.effects import CATALOGUE
from flex_ident.errors import SignalError
from flex_ident.gap import GapExplanation, GapOptions, explain
from flex_ident.recording import Recording
from flex_ident.report.gap_words import region_text
from flex_ident.report.reasons import reason_text
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain

ROOT = Path(__file__).resolve().parent.parent
MUJOCO_CAN = (
    "none", "torque_offset", "gravity", "backlash", "joint_damping", "time_delay", "encoder_skew", "saturation",
    "second_mode",
)  # fmt: skip


@dataclass(frozen=True)
class Draw:
    """One hidden effect or pair in one joint, seen by one set of sensors."""

    effects: tuple[str, ...]
    joint: str
    sensors: str
    excitation: str
    plant: str
    seed: int
    duration_s: float
    rate_hz: float
    noise: float

    @property
    def name(self) -> str:
        """Identifies the draw."""
        return "|".join(str(v) for v in asdict(self).values())


def drawn(draw: Draw) -> tuple[Recording, dict[str, float]]:
    """The recording of a draw and what is hidden in it; a size that makes the drive unstable is drawn again."""
    for attempt in range(10):
        try:
            return _drawn(draw, attempt)
        except SignalError:
            continue
    raise SignalError(f"{draw.name}: no size of it lets the drive be stable.")


def _drawn(draw: Draw, attempt: int) -> tuple[Recording, dict[str, float]]:
    profile = "rich" if draw.excitation == "rich" else "falling"
    repeats = 2 if draw.excitation == "repeated" else 1
    experiment = Experiment(
        duration_s=draw.duration_s, sample_rate_hz=draw.rate_hz, profile=profile, repeats=repeats
    )  # fmt: skip
    own = (draw.seed, list(JOINTS).index(draw.joint), *(CLASSES.index(e) for e in draw.effects), *range(attempt))
    rng = np.random.default_rng(own)
    scales = scales_of(draw.joint, experiment)
    hidden: dict[str, float] = {}
    changed: dict[str, float] = {}
    for effect in draw.effects:
        terms, other = hidden_effect(effect, dict(JOINTS[draw.joint].parameters), scales, rng)
        hidden.update(terms)
        changed.update(other)
    link = draw.sensors == "motor+link"
    noise = Noise(torque=0.01 * draw.noise, disturbance=0.005 * draw.noise)
    if draw.plant == "hidden":
        made = hidden_recording(
            draw.joint, hidden, experiment, changed=changed, seed=draw.seed, noise=noise, link=link
        )  # fmt: skip
        return made, hidden
    sys.path.insert(0, str(ROOT / "test" / "plants"))
    from mujoco_joint import mujoco_recording

    model = JOINTS[draw.joint]
    model = type(model)({**model.parameters, **changed}, joint=draw.joint)
    for effect in draw.effects:
        own = {k.split(".", 1)[1]: v for k, v in hidden.items() if k.startswith(effect + ".")}
        model = model.with_effect(effect, own) if own else model
    chain = MeasurementChain(noise.motor_step, noise.link_step, noise.torque, noise.disturbance)
    return mujoco_recording(model, experiment, chain, seed=draw.seed, link=link), hidden


def answered(draw: Draw) -> dict[str, object]:
    """What `explain` says of a draw."""
    recording, hidden = drawn(draw)
    options = GapOptions(without=("MX", "MY") if "gravity" in draw.effects else ())
    start = time.perf_counter()
    try:
        said: GapExplanation | str = explain(recording, options)
    except Exception as error:  # a bench must survive what it is there to find
        said = f"{type(error).__name__}: {error}"
    result: dict[str, object] = {
        "draw": draw.name, "effects": draw.effects, "joint": draw.joint, "sensors": draw.sensors, "hidden": hidden,
        "seconds": time.perf_counter() - start,
    }  # fmt: skip
    if isinstance(said, str):
        return {**result, "verdict": "error", "found": [], "ties": [], "error": said}
    return {
        **result,
        "verdict": said.verdict,
        "found": [f.effect for f in said.findings],
        "ties": list(said.findings[0].indistinguishable_from) if said.findings else [],
        "before": said.before,
        "after": said.after,
        "floor": said.noise_floor,
        "torque": float(np.std(recording.motor_torque)),
        "rejected": {r.effect: reason_text(r.reason) for r in said.rejected},
        "not_testable": [u.effect for u in said.not_testable],
        "parameters": {
            f"{f.effect}.{p.key}": [p.value, p.std] for f in said.findings for p in f.parameters
        },
        "where": [region_text(r) for r in said.where],
    }  # fmt: skip


def _on_one_core(cores: multiprocessing.Queue) -> None:
    """Workers that share cores only get in each other's way."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {cores.get()})


def draws(given: argparse.Namespace) -> Iterator[Draw]:
    """Every draw that was asked for."""
    classes = given.effects.split(",") if given.effects else CLASSES
    if given.plant == "mujoco":
        classes = [c for c in classes if c in MUJOCO_CAN]
    for i in range(given.draws):
        for joint in given.joints.split(","):
            for sensors in given.sensors.split(","):
                chosen: list[tuple[str, ...]] = [(c,) for c in classes]
                if given.pairs:
                    rng = np.random.default_rng([given.seed + i, list(JOINTS).index(joint)])
                    usable = [c for c in classes if c in CATALOGUE]
                    chosen = [tuple(rng.choice(usable, 2, replace=False)) for _ in range(given.pairs)]
                for effects in chosen:
                    if sensors == "motor" and set(effects) & set(NEEDS_LINK):
                        continue
                    yield Draw(
                        effects, joint, sensors, given.excitation, given.plant, given.seed + i, given.duration,
                        given.rate, given.noise,
                    )  # fmt: skip


def clean_floor(results: list[dict[str, object]]) -> dict[tuple[object, object], float]:
    """Median gap of a joint with nothing hidden, relative to its torque: what no effect can close."""
    floors: dict[tuple[object, object], list[float]] = {}
    for r in results:
        if r["effects"] == [NONE] and "after" in r:
            floors.setdefault((r["joint"], r["sensors"]), []).append(r["before"] / r["torque"])
    return {key: statistics.median(values) for key, values in floors.items()}


def closed_share(result: dict[str, object], floors: dict[tuple[object, object], float]) -> float:
    """Share of the closable gap that was closed, by rms above the floor; NaN when nothing was there to close."""
    if "after" not in result:
        return math.nan
    relative = floors.get((result["joint"], result["sensors"]))
    floor = result["floor"] if relative is None else relative * result["torque"]
    before, after = (math.sqrt(max(result[k] ** 2 - floor**2, 0.0)) for k in ("before", "after"))
    return 1.0 - after / before if result["before"] > 1.05 * floor else math.nan


def known(results: list[dict[str, object]]) -> tuple[int, int]:
    """Of the parameters of effects that were named rightly, how many intervals of 95 % hold the truth; phases left out.

    The plant's hysteresis has another law than the catalogue's, so its parameters have no truth.
    """
    inside = total = 0
    for r in results:
        for key, (value, std) in r.get("parameters", {}).items():
            effect, name = key.split(".")
            if key in r["hidden"] and effect in r["effects"] and effect != "hysteresis" and name != "phase":
                inside += abs(value - r["hidden"][key]) <= 1.96 * std
                total += 1
    return inside, total


def right_first(result: dict[str, object]) -> bool:
    """Whether what is hidden is what was named first; for an effect outside the catalogue, whether nothing was."""
    if result["effects"] == [NONE]:
        return not result["found"] and result["verdict"] == "complete"
    if result["effects"][0] in OUTSIDE:
        return not result["found"] and result["verdict"] == "unexplained"
    return bool(result["found"]) and result["found"][0] in result["effects"]


def summary(results: list[dict[str, object]], sensors: str) -> str:
    """One row a class: how often it was named first and right, the gap closed, and what was said instead.

    "not testable": not named, but said to be invisible in such data, with the experiment that would show it.
    """
    own = [r for r in results if r["sensors"] == sensors]
    floors = clean_floor(results)
    lines = [
        f"{sensors}: {len(own)} draws", "",
        "| hidden | right | draws | in a tie | not testable | visible | gap closed, median | said instead |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]  # fmt: skip
    singles = [c for c in CLASSES if any(r["effects"] == [c] for r in own)]
    rights, total, told, seen, closings = 0, 0, 0, 0, []
    for name in singles:
        rows = [r for r in own if r["effects"] == [name]]
        right = [right_first(r) for r in rows]
        wrong = Counter(
            (" + ".join(r["found"]) or str(r["verdict"])) for r, ok in zip(rows, right, strict=True) if not ok
        )
        tie = sum(not ok and name in r["ties"] for r, ok in zip(rows, right, strict=True))
        untestable = sum(not ok and name in r.get("not_testable", ()) for r, ok in zip(rows, right, strict=True))
        closed = [c for c in (closed_share(r, floors) for r in rows) if not math.isnan(c)]
        text = f"{100 * statistics.median(closed):.0f} %" if closed else ""
        said = ", ".join(f"{k} ×{v}" for k, v in wrong.most_common())
        counts = f"{sum(right)} | {len(rows)} | {tie or ''} | {untestable or ''} | {len(closed)}"
        lines.append(f"| {name} | {counts} | {text} | {said} |")
        if name in CATALOGUE:
            rights, total, told = rights + sum(right), total + len(rows), told + untestable
            closings += closed
            seen += sum(ok and not math.isnan(closed_share(r, floors)) for r, ok in zip(rows, right, strict=True))
    if total:
        lines += ["", f"named first and right: {rights} of {total} ({100 * rights / total:.1f} %)"]
        lines.append(f"of those that were not, said to be not testable with such data: {told}")
    if closings:
        share = 100 * seen / len(closings)
        lines.append(f"of those whose gap is 5 % above a clean joint's: {seen} of {len(closings)} ({share:.1f} %)")
    if closings:
        lines.append(f"closable gap closed, median: {100 * statistics.median(closings):.0f} %")
    inside, of = known(own)
    if of:
        lines.append(f"parameters of what was named rightly inside their own 95 % intervals: {inside} of {of}")
    clean = [r for r in own if r["effects"] == [NONE]]
    if clean:
        lines.append(f"false names with nothing hidden: {sum(bool(r['found']) for r in clean)} of {len(clean)}")
    pairs = [r for r in own if len(r["effects"]) == 2]
    if pairs:
        both = sum(set(r["effects"]) <= set(r["found"]) for r in pairs)
        lines.append(f"pairs, both named: {both} of {len(pairs)}")
        lines += [f"  {' + '.join(r['effects'])}: {' + '.join(r['found']) or r['verdict']}" for r in pairs
                  if not set(r["effects"]) <= set(r["found"])]  # fmt: skip
    lines.append(f"seconds a search, median: {statistics.median(r['seconds'] for r in own):.1f}")
    return "\n".join(lines)


def main() -> None:
    """Run the draws that are not there yet, and print the summary."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--joints", default=",".join(JOINTS))
    parser.add_argument("--sensors", default="motor+link,motor")
    parser.add_argument("--effects", default="", help="classes, comma-separated; all when left out")
    parser.add_argument("--excitation", default="chirp", choices=("chirp", "rich", "repeated"))
    parser.add_argument("--plant", default="hidden", choices=("hidden", "mujoco"))
    parser.add_argument("--pairs", type=int, default=0, help="instead: this many random pairs a draw")
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--noise", type=float, default=1.0, help="times 1 %% torque noise, 0.5 %% disturbance")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # for the workers
    wanted = list(draws(given))
    results: list[dict[str, object]] = []
    if given.out and given.out.exists():
        results = [json.loads(line) for line in given.out.read_text().splitlines()]
    done = {r["draw"] for r in results}
    missing = [d for d in wanted if d.name not in done]
    context = multiprocessing.get_context("spawn")
    cores = context.Queue()
    for i in range(given.jobs):
        cores.put(i % (os.cpu_count() or 1))
    with context.Pool(given.jobs, _on_one_core, (cores,)) as pool:
        for i, result in enumerate(pool.imap_unordered(answered, missing)):
            result = json.loads(json.dumps(result))
            results.append(result)
            print(f"{i + 1}/{len(missing)} {result['draw'][:60]}: {result['found'] or result['verdict']}",
                  file=sys.stderr, flush=True)  # fmt: skip
            if given.out:
                with given.out.open("a") as file:
                    file.write(json.dumps(result) + "\n")
    names = {d.name for d in wanted}
    shown = [r for r in results if r["draw"] in names]
    for sensors in given.sensors.split(","):
        if any(r["sensors"] == sensors for r in shown):
            print(summary(shown, sensors), end="\n\n")


if __name__ == "__main__":
    main()
