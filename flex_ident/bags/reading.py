"""From a bag and a selection to the joint's recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from flex_ident.bags.encoders import refuse_opposite, repeats_motor, unwrapped
from flex_ident.bags.finding import SignalFinder, SignalPlaces
from flex_ident.bags.motions import JointMotion, joint_motions
from flex_ident.bags.other_joints import Track, moved_notice, other_places, poses, tracks
from flex_ident.bags.raw_signals import raw_signals
from flex_ident.bags.selection import Place, SignalSelection
from flex_ident.bags.storage import Bag
from flex_ident.errors import BagError, ExcitationError, SignalError
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording, Signal
from flex_ident.recording.alignment import aligned_recording
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.clocks import RawSignal, signals_of
from flex_ident.recording.empty_messages import without_empty_messages
from flex_ident.recording.laid_over import without_laid_over
from flex_ident.recording.mending import mended_signals
from flex_ident.recording.names import first_of
from flex_ident.recording.recording import Role
from flex_ident.recording.stillness import refuse_held
from flex_ident.report.sentences import sentence

__all__ = ["JointMotion", "Progress", "joint_motions", "read_recording"]

Progress = Callable[[float], None]
NO_SIGNALS = ("rosout", "rosout_agg", "parameter_events", "tf", "tf_static", "robot_description", "clock", "events")
"""Last parts of the names of topics that hold no signal of a joint."""
MOST_NAMED = 8
"""Topics that a message names at most."""


def read_recording(
    path: Path | str, selection: SignalSelection | None = None, *, progress: Progress | None = None
) -> Recording:
    """The joint's recording on one uniform clock. Raises BagError, SignalError, ExcitationError and UsageError."""
    selection = selection or SignalSelection()
    with Bag(Path(path)) as bag:
        bag.define(selection.type_files)
        try:
            return _recording(bag, selection, progress)
        except (SignalError, ExcitationError) as error:
            damage = [sentence(n) for n in bag.damage() if n.code is Code.BAG_DAMAGED]
            if not damage:
                raise
            raise BagError(f"{error} The bag is damaged: {damage[0]}") from error


def _recording(bag: Bag, selection: SignalSelection, progress: Progress | None) -> Recording:
    with ThreadPoolExecutor(1) as pool:
        digest = pool.submit(bag.sha256)
        joint, signals, notices, origin, others, held = _signals(bag, selection, progress)
    _check_signals(signals, joint, named=selection.effort, others=possible_topics(bag))
    return aligned_recording(
        signals, joint=joint, notices=notices, path=bag.name, sha256=digest.result(), start_time_s=origin,
        others=others, poses=held,
    )  # fmt: skip


def _signals(
    bag: Bag, selection: SignalSelection, progress: Progress | None
) -> tuple[str, list[Signal], list[Notice], float, dict[str, Track], dict[str, float]]:
    """The joint's name, its signals, what was done to them, their origin, s, and where other joints were: those that
    moved over time, and all of them on average."""
    finder = SignalFinder(bag, selection)
    candidates = finder.candidates()
    topics = dict.fromkeys(places.motor.topic for places in candidates)
    names = [places.motor.name or places.joint for places in candidates]
    beside = other_places(bag, [finder.topics[topic] for topic in topics], [*names, candidates[0].joint])
    wanted = [p for places in candidates for p in places.all()]
    found, notices = raw_signals(bag, [*wanted, *beside], progress=progress)
    chosen = next((places for places in candidates if found[places.motor].received.size), None)
    if chosen is None:
        raise finder.missing(candidates[0])
    if selection.link_position and chosen.motor in chosen.links:
        raise _no_second_encoder(chosen.motor.source)
    raw = _by_role(chosen, found, selection)
    efforts = raw["motor_torque"].values
    if measurable(raw["motor_position"].values).any() and not measurable(efforts).any():
        what = f"none of {efforts.size} values that is a finite number" if efforts.size else "no messages"
        refuse_without_effort(chosen.torque.source, f"holds {what}", possible_topics(bag), selection.effort)
    factors: dict[Role, float] = {"motor_position": 1.0 / selection.gear_ratio, "motor_torque": selection.effort_scale}
    raw, overlaid = without_laid_over(raw)
    raw, emptied = without_empty_messages(raw)
    signals, dropped, origin = signals_of(raw, joint=chosen.joint, factors=factors)
    signals, wrapped = unwrapped(signals, factors)
    signals, mended = mended_signals(signals, {role: abs(factor) for role, factor in factors.items()})
    if repeats_motor(signals):
        if selection.link_position or selection.sensors == "motor+link":
            raise _no_second_encoder(raw["link_position"].source)
        dropped.append(Notice(Code.LINK_REPEATS_MOTOR, raw["link_position"].source))
        signals = [signal for signal in signals if signal.role != "link_position"]
    refuse_opposite(signals)
    near = {p.name: found[p] for p in beside if p.topic == chosen.motor.topic and p not in chosen.all()}
    others = tracks(near, next(s for s in signals if s.role == "motor_position"), origin)
    moved = moved_notice(others)
    said = [
        *bag.notices(),
        *notices,
        *overlaid,
        *emptied,
        *dropped,
        *wrapped,
        *mended,
        *_unit_notices(selection, chosen),
    ]
    collected = dict.fromkeys([*said, *([moved] if moved is not None else [])])
    return chosen.joint, signals, list(collected), origin, others, poses(near)


def _by_role(places: SignalPlaces, found: dict[Place, RawSignal], selection: SignalSelection) -> dict[Role, RawSignal]:
    raw: dict[Role, RawSignal] = {"motor_position": found[places.motor], "motor_torque": found[places.torque]}
    link = next((found[p] for p in places.links if _range(found[p]) > 0.0), None)
    if link is not None:
        raw["link_position"] = link
    elif selection.link_position and selection.sensors != "motor":
        still = found[places.links[0]]
        what = "does not move" if still.received.size else "is not in the recording"
        raise SignalError(
            f"link position {still.source} {what}: name another with --link-position, or --sensors motor."
        )
    elif selection.sensors == "motor+link":
        raise SignalError(f"no link position of {places.joint} that moves: name one with --link-position.")
    if places.reference is not None:
        reference = found[places.reference]
        if selection.reference and not measurable(reference.values).any():
            raise SignalError(f"{reference.source} holds no numbers: name another signal with --reference.")
        raw["reference"] = reference
    if places.current is not None:
        raw["motor_current"] = found[places.current]
        if not _range(raw["motor_current"]) > 0.0:
            what = (
                "does not change" if measurable(raw["motor_current"].values).any() else "holds no messages with numbers"
            )
            raise SignalError(f"{places.current.source} {what}: name another signal with --motor-current.")
    return raw


def _range(raw: RawSignal) -> float:
    finite = raw.values[measurable(raw.values)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _unit_notices(selection: SignalSelection, places: SignalPlaces) -> list[Notice]:
    """Warnings when the effort is by its name a current, or the motor's position on the other side of the gear."""
    if selection.effort_scale != 1.0:
        return []
    notices = []
    if "current" in places.torque.source.lower():
        notices.append(Notice(Code.EFFORT_CURRENT, places.torque.source, texts={"case": "by_name"}))
    if abs(selection.gear_ratio) != 1.0:
        notices.append(Notice(Code.EFFORT_SIDE, "motor_torque", {"gear_ratio": selection.gear_ratio}))
    return notices


def _no_second_encoder(source: str) -> SignalError:
    return SignalError(
        f"link position {source} is the motor position itself: name a second encoder's with --link-position, or take "
        "--sensors motor."
    )


def _check_signals(signals: list[Signal], joint: str, *, named: str | None, others: Sequence[str]) -> None:
    """Raises ExcitationError without motion, SignalError without effort; `named` by the user: another is to be."""
    by_role = {s.role: s for s in signals}
    motor, torque = by_role["motor_position"], by_role["motor_torque"]
    refuse_held(joint, motor.values)
    if float(np.ptp(torque.values)) == 0.0:
        what = "zero throughout" if not torque.values.any() else f"constant at {torque.values[0]:.4g}"
        refuse_without_effort(torque.source, f"is {what}", others, named)


def refuse_without_effort(source: str, what: str, others: Sequence[str], named: str | None) -> None:
    """Raises SignalError: what is wrong with the effort, and which topics may hold it instead."""
    own = source.partition(":")[0]
    there = [topic for topic in others if topic != own]
    among = f", of {first_of(there, MOST_NAMED)}" if there else ""
    how = (
        f"it is what --effort names: name another signal{among}, or record again while the drive reports its effort."
        if named is not None
        else f"name the effort's signal with --effort{among}."
    )
    raise SignalError(f"{source} {what}: {how}")


def possible_topics(bag: Bag) -> list[str]:
    """Topics that may hold a signal, by name: all but those that every ROS system has for other things."""
    return sorted(t.name for t in bag.topics() if t.name.rpartition("/")[2] not in NO_SIGNALS)
