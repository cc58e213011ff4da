"""The tables of `coverage.py`, from its lines."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

Line = dict[str, Any]
KEYS = ("Jm", "K", "JL", "J", "FVm", "FSm", "FV", "FS", "MY")
MAIN = ("Jm", "K", "JL")
GROUPS = ("controller", "excitation", "rate", "joint", "friction", "effort", "loud")
VERDICTS = ("trusted", "doubtful", "rejected", "error")
FAR = 3.0
FARTHEST_LINES = 12


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Columns of text, the first to the left, the others to the right."""
    cells = [[str(v) for v in row] for row in (header, *rows)]
    widths = [max(len(row[j]) for row in cells) for j in range(len(header))]
    return "\n".join(
        "  ".join(v.ljust(w) if j == 0 else v.rjust(w) for j, (v, w) in enumerate(zip(row, widths, strict=True)))
        for row in cells
    )


def percent(part: int, whole: int) -> str:
    """Share in percent, or a dash of nothing."""
    return f"{100.0 * part / whole:.0f}" if whole else "-"


def truth_of(line: Line) -> dict[str, float]:
    """The true parameters of the model that a line's result is of."""
    truth: dict[str, float] = line["truth"]
    if "J" in line["parameters"]:
        both = {"J": ("Jm", "JL"), "FV": ("FVm", "FV"), "FS": ("FSm", "FS")}
        truth = {**truth, **{k: sum(truth[part] for part in parts) for k, parts in both.items()}}
    return truth


def outside(line: Line, key: str, low: float, high: float) -> tuple[float, float]:
    """Distance of a range from the truth, and the end of the truth that counts.

    The truth of JL under a second mode and of K under hysteresis is itself a range. A joint that is taken as rigid has
    the inertia and the friction of both sides.
    """
    truth = truth_of(line)
    ends = sorted({truth[key], *(truth[k] for k in (f"{key}_low", f"{key}_high") if k in truth)})
    first, last = ends[0], ends[-1]
    if high < first:
        return high - first, first
    if low > last:
        return low - last, last
    return 0.0, min(max(0.5 * (low + high), first), last)


def pull(line: Line, key: str) -> float:
    """Error over stated standard deviation; infinite where none is stated and it is wrong."""
    p = line["parameters"][key]
    error, _ = outside(line, key, p["value"], p["value"])
    if p["std"] > 0.0:
        return error / p["std"]
    return 0.0 if error == 0.0 else math.copysign(math.inf, error)


def stated(lines: list[Line], key: str) -> list[Line]:
    """Lines whose result gives this parameter as identifiable."""
    return [line for line in lines if line.get("parameters", {}).get(key, {}).get("identifiable")]


def covered(line: Line, key: str) -> bool:
    """Whether the 95 % interval holds the truth."""
    low, high = line["parameters"][key]["interval"]
    return outside(line, key, low, high)[0] == 0.0


def parameter_rows(lines: list[Line]) -> list[list[object]]:
    """One row a parameter: how its intervals hold."""
    answered = [line for line in lines if "parameters" in line]
    rows: list[list[object]] = []
    for key in KEYS:
        own = stated(answered, key)
        if not own:
            rows.append([key, 0, len(answered), *["-"] * 7])
            continue
        pulls = np.array([pull(line, key) for line in own])
        finite = pulls[np.isfinite(pulls)]
        middle = np.median(finite) if finite.size else math.nan
        share = [line["parameters"][key]["std"] / abs(truth_of(line)[key]) for line in own]
        rows.append([
            key, len(own), len(answered) - len(own), percent(sum(covered(line, key) for line in own), len(own)),
            f"{middle:+.2f}", f"{1.4826 * np.median(np.abs(finite - middle)):.2f}",
            f"{math.sqrt(float(np.mean(finite**2))):.2f}", percent(int(np.sum(np.abs(pulls) > FAR)), pulls.size),
            f"{np.max(np.abs(pulls)):.1f}", f"{100.0 * float(np.median(share)):.3g}",
        ])  # fmt: skip
    return rows


PARAMETER_HEADER = (
    "", "given", "not id.", "cover 95 %", "median pull", "1.48 MAD", "rms", "|pull|>3 %", "worst", "std %"
)  # fmt: skip


def verdict_row(lines: list[Line]) -> list[object]:
    """Share of each verdict, percent."""
    found = Counter(line["verdict"] for line in lines)
    return [len(lines), *(percent(found[v], len(lines)) for v in VERDICTS)]


def group_rows(lines: list[Line], column: str) -> list[list[object]]:
    """For each value of a column: verdicts, coverage of every parameter and how many main pulls are far."""
    rows = []
    for value in sorted({line[column] for line in lines}):
        own = [line for line in lines if line[column] == value]
        cover = []
        for key in KEYS:
            given = stated(own, key)
            cover.append(percent(sum(covered(line, key) for line in given), len(given)))
        main = [abs(pull(line, key)) > FAR for key in MAIN for line in stated(own, key)]
        rows.append([f"{column} {value}", *verdict_row(own), *cover, percent(sum(main), len(main))])
    return rows


def farthest(line: Line) -> float:
    """The largest pull of Jm, K and JL where they are given."""
    return max((abs(pull(line, key)) for key in MAIN if stated([line], key)), default=0.0)


def described(line: Line) -> str:
    """One result in a line, to look at again with `--only`."""
    pulls = " ".join(f"{key} {pull(line, key):+.1f}" for key in KEYS if stated([line], key))
    what = f"{line['joint']}, {line['controller']}, {line['excitation']}, {line['rate']:.0f} Hz, {line['effort']}"
    hidden = f"{line['effect']} {line['size']}" if line["effect"] else line["stratum"]
    return f"  {line['index']}: {what}, {line['friction']}, {hidden}, {line['verdict']}; {pulls}"


GROUP_HEADER = ("", "n", *VERDICTS, *KEYS, "main>3 %")


def right(line: Line) -> bool:
    """Whether Jm, K and JL, where given, lie within three standard deviations."""
    return all(abs(pull(line, key)) <= FAR for key in MAIN if stated([line], key))


def hidden_rows(lines: list[Line], value: Callable[[Line], str]) -> list[list[object]]:
    """By effect: how many trusted and doubtful results have Jm, K and JL within three standard deviations."""
    rows = []
    for name in sorted({value(line) for line in lines}):
        own = [line for line in lines if value(line) == name]
        row: list[object] = [name, *verdict_row(own)]
        for verdict in ("trusted", "doubtful"):
            some = [line for line in own if line["verdict"] == verdict]
            good = sum(right(line) for line in some)
            row += [f"{good}/{len(some)}", percent(good, len(some))]
        rows.append(row)
    return rows


def finding_tables(lines: list[Line], hidden: bool) -> None:
    """False findings of clean recordings, or the first finding of hidden ones."""
    if not hidden:
        print("\nexplain, nothing hidden: verdicts and accepted findings (each is false)")
        for sensors in sorted({line["sensors"] for line in lines}):
            own = [line for line in lines if line["sensors"] == sensors]
            false = [[e for e, v in line.get("findings", []) if v == "accepted"] for line in own]
            named = Counter(e for effects in false for e in effects)
            print(f"  {sensors}: {dict(Counter(line['verdict'] for line in own))}")
            print(f"    {sum(map(bool, false))} of {len(own)} with a false finding: {dict(named)}")
        return
    print("\nexplain: first accepted finding by hidden effect")
    for effect in sorted({line["effect"] for line in lines}):
        own = [line for line in lines if line["effect"] == effect]
        firsts = Counter(
            next((e for e, v in line.get("findings", []) if v == "accepted"), f"({line['verdict']})") for line in own
        )
        print(f"  {effect} ({len(own)}): {', '.join(f'{k} {v}' for k, v in firsts.most_common())}")


def print_tables(lines: list[Line]) -> None:
    """Everything that the lines tell."""
    if not lines:
        print("nothing recorded yet")
        return
    hidden = bool(lines[0]["hidden"])
    identified = [line for line in lines if line["name"].endswith("identify")]
    for sensors in sorted({line["sensors"] for line in identified}):
        own = [line for line in identified if line["sensors"] == sensors]
        standard = [line for line in own if line["stratum"] == "standard"]
        print(f"\n=== {sensors}: {len(own)} results, {'one effect hidden' if hidden else 'nothing hidden'} ===")
        if hidden:
            header = ("", "n", *VERDICTS, "trusted right", "%", "doubtful right", "%")
            print(table(header, hidden_rows(own, lambda line: "all")))
            print(table(header, hidden_rows(own, lambda line: line["effect"])))
            print(table(header, hidden_rows(own, lambda line: f"size {line['size']}")))
        for title, part in (
            ("standard", standard), ("trusted of these", [x for x in standard if x["verdict"] == "trusted"]),
            *((s, [x for x in own if x["stratum"] == s]) for s in ("slow", "lag")),
        ):  # fmt: skip
            if part:
                print(f"\n{title}: {len(part)}; verdicts {dict(Counter(x['verdict'] for x in part))}")
                print(table(PARAMETER_HEADER, parameter_rows(part)))
        print("\ncoverage of 95 % intervals, percent (standard)")
        print(table(GROUP_HEADER, [row for column in GROUPS for row in group_rows(standard, column)]))
        notices = Counter(code for line in own for code in line.get("notices", []))
        print("\nfarthest (recording: joint, controller, excitation, rate, effort, friction, hidden; pulls)")
        for line in sorted(own, key=farthest, reverse=True)[:FARTHEST_LINES]:
            print(described(line))
        print(f"\nnotices: {dict(notices.most_common(12))}")
        print(f"median seconds: {float(np.median([line['seconds'] for line in own])):.1f}")
    for line in lines:
        if "error" in line:
            print(f"error {line['name']} {line['joint']} {line['controller']} {line['excitation']}: {line['error']}")
    explained = [line for line in lines if line["name"].endswith("explain")]
    if explained:
        finding_tables(explained, hidden)
