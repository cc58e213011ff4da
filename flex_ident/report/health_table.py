"""The health of a fleet for a person at a terminal: what changed, joint by joint, and what is likely behind it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from flex_ident.recording.names import harmless
from flex_ident.report.table import rounded, text_table

HEADER = ("robot", "joint", "parameter", "before", "after", "unit", "change", "95 % interval", "chance", "since")
CAUSES = {
    "effort_scale": "all changed alike: probably not the joint but the effort's scale (torque constant, torque sensor)",
    "gear_wear": "backlash grew: probably wear of the gear",
    "transmission": "stiffness fell: probably wear of the gear, a belt that lost tension, or bolts that came loose",
    "stiffer": "stiffness rose: probably a part was changed or tightened, or the load is another",
    "payload": "the link's inertia or first moment changed: probably another tool, payload or cable",
    "temperature": "friction changed, and so did the temperature: probably that; compare at one temperature",
    "lubrication": "friction alone changed: probably lubrication or temperature",
    "dry_friction": "dry friction alone grew: probably preload, a seal, a dragging brake, or lubrication",
    "offset": "the offset alone changed: probably the zero of the effort, or gravity that the controller takes away",
    "several": "several things changed at once: explain_gap on a recording from before and one from after tells more",
    "version": "results before and after are of other versions of flex_ident: probably that, and not the joint; run "
    "flex_ident batch over all recordings with one version",
}
"""What each probable cause of `fleet.causes` means."""

MOST_MIXED = 5
"""Joints of several methods or settings that are named."""
TO_CONFIRM = "Off, and not surely (the newest session alone, or of three in all); one of another day would tell:"


def health_text(content: Mapping[str, Any]) -> str:
    """The changes, their causes, what waits for a second result, and how it was judged."""
    held = content["false_alarms"]
    total = len(content["joints"])
    states = ", ".join(f"{count} {text}" for text, count in counted_states(content))
    lines = [f"{total} joint{'' if total == 1 else 's'}: {states}"]
    if content["changes"]:
        lines += ["", _table(content["changes"]), ""]
        for joint in content["joints"]:
            if joint["state"] == "changed":
                lines.append(f"{_name(joint)}: {CAUSES[joint['cause']]}.")
    if content["to_confirm"]:
        lines += ["", TO_CONFIRM]
        lines += [_table(content["to_confirm"])]
    lines += mixed_lines(content)
    lines += [
        "",
        f"Baseline: {content['baseline']}. {held['comparisons']} comparisons; of the changes named no more than "
        f"{100.0 * held['rate']:.0f} % are false on average ({held['method']} over all of them).",
        limits_text(content),
    ]
    return "\n".join(lines)


def mixed_lines(content: Mapping[str, Any]) -> list[str]:
    """What is not compared: results by other methods or settings, joint by joint, and those of bags replaced."""
    mixed = content["mixed"]
    lines = [
        f"{_name(own)}: results by {len(own['models'])} methods or settings, which are not compared with each other "
        f"({'; '.join(own['models'])}). Run flex_ident batch over all its recordings with one."
        for own in mixed[:MOST_MIXED]
    ]
    if len(mixed) > MOST_MIXED:
        lines.append(f"{len(mixed) - MOST_MIXED} more joints have results by several methods or settings.")
    replaced = content["replaced"]
    if replaced:
        count = sum(own["recordings"] for own in replaced)
        lines.append(
            f"{len(replaced)} bag{'s were' if len(replaced) > 1 else ' was'} replaced by "
            f"{'others' if len(replaced) > 1 else 'another'} of the same name and day ({harmless(replaced[0]['bag'])}"
            f"{', ...' if len(replaced) > 1 else ''}): what is in the archive of the {count} old recording"
            f"{'s' if count > 1 else ''} does not count."
        )
    return ["", *lines] if lines else []


def counted_states(content: Mapping[str, Any]) -> list[tuple[str, int]]:
    """How many joints are in each state, in words; states without a joint are left out."""
    states = Counter(joint["state"] for joint in content["joints"])
    named = (
        ("changed", "changed"), ("to_confirm", "to be confirmed"), ("unchanged", "unchanged"),
        ("not_judged", f"cannot tell yet: {few_sessions(content)}"),
    )  # fmt: skip
    return [(text, states[state]) for state, text in named if states[state]]


def few_sessions(content: Mapping[str, Any]) -> str:
    """How many sessions the joints have that are not judged, and what would do."""
    counts = sorted({joint["sessions"] for joint in content["joints"] if joint["state"] == "not_judged"})
    if not counts:
        return ""
    text = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    return f"{text} session{'' if counts == [1] else 's'}; record on four days or more"


def smallest_rows(content: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """A row a parameter: the smallest change that could have been shown, in the median and in the worst joint."""
    return [
        (key, f"{own['median_percent']:.2g} %", f"{own['worst_percent']:.2g} %", str(own["series"]))
        for key, own in content["smallest"].items()
    ]


def limits_text(content: Mapping[str, Any]) -> str:
    """The smallest change of the chief parameters that the archive could have shown, in a sentence."""
    known = content["smallest"]
    chief = [key for key in ("K", "K/JL", "J", "JL", "FVm", "FSm", "FV", "FS") if key in known]
    if not chief:
        return "Nothing says how small a change could have been shown."
    said = ", ".join(f"{key} {known[key]['median_percent']:.2g} %" for key in chief)
    return f"The smallest change that could have been shown, in the median joint: {said}. Smaller ones may be there."


def worded(content: Mapping[str, Any]) -> dict[str, Any]:
    """The same content with each joint's cause in words beside its name."""
    joints = [{**own, "cause_text": CAUSES[own["cause"]]} if "cause" in own else own for own in content["joints"]]
    return {**content, "joints": joints}


def _name(joint: Mapping[str, Any]) -> str:
    return f"{joint['robot']} {joint['joint']}".strip()


def _table(changes: Sequence[Mapping[str, Any]]) -> str:
    return text_table(HEADER, [change_row(change) for change in changes], right=(3, 4, 6, 7, 8))


def change_row(change: Mapping[str, Any]) -> tuple[str, ...]:
    """A row of `HEADER` for a change."""
    low, high = change["ci95"]
    half = (high - low) / 2.0
    share, chance = change["change_percent"], change["chance"]
    by = f"{change['change']:+.3g}" if share is None else f"{share:+.3g} %"
    within = f"{low:+.3g} to {high:+.3g}"
    if share is not None:
        within = " to ".join(f"{own:+.3g}" for own in change["ci95_percent"]) + " %"
    return (
        change["robot"], change["joint"], change["parameter"], rounded(change["before"]["value"], half),
        rounded(change["after"]["value"], half), change["unit"], by, within,
        f"{chance:.2g}" if chance >= 1e-6 else "< 1e-6", change["since"]["until"][:10],
    )  # fmt: skip
