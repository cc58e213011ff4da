"""What to do about a result: the one thing to do first, then the rest with like put together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from flex_ident.judgement.priorities import DOUBTS, EXPERIMENTS, REFUSALS, SIGNALS_FIRST
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Identification
from flex_ident.report.sentences import sentence
from flex_ident.report.worded import experiment_for

UNRELATED_PERCENT = 90.0
"""A model that leaves this share of the torque describes nothing of it."""
HALF_PERCENT = 50.0
FOLLOW = (Code.CAUSE_SUSPECTED, Code.STRUCTURED_RESIDUAL, Code.UNDETERMINED, Code.LOW_EXCITATION)
"""Codes that say nothing where the signals are not of one joint alone, or not what they were taken for."""
Kind = Literal["signals", "action", "warning"]


@dataclass(frozen=True)
class Advice:
    """The one thing to do first, and the notices whose sentences it holds.

    `signals`: the recorded signals must be looked at before anything else means something; `action`: do something else
    with the same recording or another; `warning`: a notice's own sentence.
    """

    kind: Kind
    text: str
    covers: tuple[Notice, ...] = ()


def told(notices: Iterable[Notice]) -> tuple[str, ...]:
    """The sentence of each notice once, in order."""
    return tuple(dict.fromkeys(sentence(n) for n in notices))


def first_thing(result: Identification) -> str | None:
    """The one thing to do about a result that is not trusted, in words; None where nothing stands out."""
    found = first_advice(result)
    return None if found is None else found.text


def first_advice(result: Identification) -> Advice | None:
    """The one thing to do about a result that is not trusted; None where nothing stands out."""
    if result.verdict == "trusted":
        return None
    said = {n.code: n for n in reversed(result.notices)}
    for code in SIGNALS_FIRST:
        if code in said:
            first = _as_said(said[code])
            return replace(first, kind="signals") if result.verdict == "rejected" else first
    if result.verdict == "doubtful":
        return _objection(result, DOUBTS)
    return _remedy(result, said)


def _as_said(notice: Notice) -> Advice:
    return Advice("warning", begun(sentence(notice)), (notice,))


def _remedy(result: Identification, said: dict[Code, Notice]) -> Advice | None:
    """What to do about a rejected result."""
    left = result.fit.validation_relative_error_percent
    left = max(left, result.fit.relative_error_percent)
    weak = [p.key for p in result.parameters if p.key in ESSENTIAL and not p.identifiable]
    if not left < UNRELATED_PERCENT:
        return Advice(
            "signals",
            f"Check the effort signal: the model leaves {left:.0f} % of it, so it has next to nothing to do with the "
            "recorded motion. Is it this joint's effort (--effort), does it hold more than noise, and does one clock "
            "stamp both? No other experiment helps before that.",
        )
    if Code.MOTOR_EQUATION not in said and Code.OTHER_JOINTS_MOVE in said and (weak or left > HALF_PERCENT):
        return _alone(said[Code.OTHER_JOINTS_MOVE], left)
    if Code.MOTOR_EQUATION in said:
        return _of_the_motors_equation(said[Code.MOTOR_EQUATION], rigid=result.model.rigid)
    if left > HALF_PERCENT and weak and not result.model.rigid:
        return Advice(
            "signals",
            f"Check that the signals belong together: the model leaves {left:.0f} % of the torque. Are unit and sign "
            "of the effort right (--effort-scale), is the position this joint's, and did the other axes stand still?",
        )
    if weak and not (result.model.rigid and left > HALF_PERCENT):
        how = experiment_for(weak[0] if len(weak) == 1 or "K" not in weak else "K")
        text = f"Record again: {how}. {_listed(weak)} not determined, and everything else hangs on that."
        return Advice("warning", text)
    if result.model.rigid and left > HALF_PERCENT:
        text = f"Identify without --rigid: the model of a rigid joint leaves {left:.0f} % of the torque."
        return Advice("action", text)
    if Code.NOT_PHYSICAL in said:
        notice = said[Code.NOT_PHYSICAL]
        return Advice("signals", f"Check sign and scale of the effort (--effort-scale): {sentence(notice)}", (notice,))
    return _objection(result, (*REFUSALS, Code.MODEL_MISMATCH, *DOUBTS))


def _alone(notice: Notice, left: float) -> Advice:
    """What to do where other joints moved, whose motion loads this one."""
    text = (
        f"Record this joint alone, all others held: {sentence(notice)} Their inertia and gravity load this joint, and "
        f"the model of one joint leaves {left:.0f} % of the torque. No other experiment helps before that."
    )
    return Advice("signals", text, (notice,))


def _objection(result: Identification, codes: Iterable[Code]) -> Advice | None:
    """What the first of these codes says that doubts or rejects."""
    said = {n.code: n for n in reversed(result.notices) if n.severity != "info"}
    return next((_as_said(said[code]) for code in codes if code in said), None)


def _of_the_motors_equation(notice: Notice, *, rigid: bool) -> Advice:
    """What to do where the motor's equation was tried alone: it determines K, or not even that (then it says why)."""
    if notice.case != "determined":
        return _as_said(notice)
    if rigid:
        return Advice("action", f"Identify without --rigid: {sentence(notice)}", (notice,))
    how = "Take K from the motor's equation, nothing else, and record again with all other axes at rest"
    return Advice("action", f"{how}: {sentence(notice)}", (notice,))


def other_things(result: Identification) -> tuple[str, ...]:
    """The other warnings, each once; what is not determined goes by the experiment that would determine it."""
    first = first_advice(result)
    kind = None if first is None else first.kind
    covered = () if first is None else first.covers
    apart = kind == "signals" or (kind == "action" and any(n.code is Code.MOTOR_EQUATION for n in covered))
    kept = [
        n
        for n in result.notices
        if n.code is not Code.NOT_IDENTIFIABLE and n not in covered
        and not (kind in ("signals", "action") and n.code is Code.MODEL_MISMATCH)
        and not (apart and n.code in FOLLOW)
    ]  # fmt: skip
    said = tuple(begun(text) for text in told(kept))
    weak = [p.key for p in result.parameters if not p.identifiable]
    if apart and weak:
        return (*said, f"{_listed(weak)} not determined by this recording, as things are.")
    return (*said, *_undetermined(result, [n for n in result.notices if n.code is Code.NOT_IDENTIFIABLE]))


def _undetermined(result: Identification, notices: list[Notice]) -> tuple[str, ...]:
    """One line an experiment, the keys that it would determine named together."""
    keys: dict[str, list[str]] = {}
    unknown = []
    for notice in dict.fromkeys(notices):
        how = EXPERIMENTS.get(notice.subject)
        if how is None or not any(p.key == notice.subject for p in result.parameters):
            unknown.append(sentence(notice))
        else:
            keys.setdefault(how, []).append(notice.subject)
    return (*(f"{_listed(names)} not determined by this recording: {how}." for how, names in keys.items()), *unknown)


def _listed(names: list[str]) -> str:
    """`K is`, `K and JL are`."""
    if len(names) == 1:
        return f"{names[0]} is"
    return f"{', '.join(names[:-1])} and {names[-1]} are"


def begun(text: str) -> str:
    """The text with a capital at its start, unless it starts with a name that has none, as of an effect."""
    return text if "_" in text.partition(" ")[0] else text[:1].upper() + text[1:]
