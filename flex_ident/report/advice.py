"""What to do about a result: the one thing to do first, then the rest with like put together."""

from __future__ import annotations

from collections.abc import Iterable

from flex_ident.parameters import Identification
from flex_ident.recording import Notice
from flex_ident.regression.verdict import ESSENTIAL, EXPERIMENTS

UNRELATED_PERCENT = 90.0
"""A model that leaves this share of the torque describes nothing of it."""
HALF_PERCENT = 50.0
SIGNALS_FIRST = ("effort_reversed", "effort_not_si", "position_not_si")
"""Codes that say that a signal is not what it was taken for: all else follows from it."""
DOUBTS = (
    "mode_outside_band", "low_excitation", "low_sampling_rate", "simplified_model", "x5_inconsistent", "torque_delay",
    "link_skew", "validation_gap", "model_mismatch",
)  # fmt: skip
"""Codes for which a result is doubtful, the most telling first."""


def told(notices: Iterable[Notice]) -> tuple[str, ...]:
    """Each message once, in order."""
    return tuple(dict.fromkeys(n.message for n in notices))


def first_thing(result: Identification) -> str | None:
    """The one thing to do about a result that is not trusted; None where nothing stands out."""
    if result.verdict == "trusted":
        return None
    said = {n.code: n.message for n in reversed(result.notices)}
    for code in SIGNALS_FIRST:
        if code in said:
            return _sentence(said[code])
    if result.verdict == "doubtful":
        return next((_sentence(said[code]) for code in DOUBTS if code in said), None)
    return _remedy(result, said)


def _remedy(result: Identification, said: dict[str, str]) -> str | None:
    """What to do about a rejected result."""
    left = result.fit.validation_relative_error_percent
    left = max(left, result.fit.relative_error_percent)
    weak = [p.key for p in result.parameters if p.key in ESSENTIAL and not p.identifiable]
    if not left < UNRELATED_PERCENT:
        return (
            f"Check the effort signal: the model leaves {left:.0f} % of it, so it has next to nothing to do with the "
            "recorded motion. Is it this joint's effort (--effort), does it hold more than noise, and does one clock "
            "stamp both? No other experiment helps before that."
        )
    if "motor_equation" in said:
        return _of_the_motors_equation(said["motor_equation"], rigid=result.model.rigid)
    if left > HALF_PERCENT and weak and not result.model.rigid:
        return (
            f"Check that the signals belong together: the model leaves {left:.0f} % of the torque. Are unit and sign "
            "of the effort right (--effort-scale), is the position this joint's, and did the other axes stand still?"
        )
    if weak and not (result.model.rigid and left > HALF_PERCENT):
        how = EXPERIMENTS[weak[0] if len(weak) == 1 or "K" not in weak else "K"]
        return f"Record again: {how}. {_listed(weak)} not determined, and everything else hangs on that."
    if result.model.rigid and left > HALF_PERCENT:
        return f"Identify without --rigid: the model of a rigid joint leaves {left:.0f} % of the torque."
    if "not_physical" in said:
        return "Check sign and scale of the effort (--effort-scale): " + said["not_physical"]
    return _sentence(said["model_mismatch"]) if "model_mismatch" in said else None


def _of_the_motors_equation(text: str, *, rigid: bool) -> str:
    """What to do where the motor's equation was tried alone: it determines K, or not even that (then it says why)."""
    if "K = " not in text:
        return _sentence(text)
    if rigid:
        return f"Identify without --rigid: {text}"
    return f"Take K from the motor's equation, nothing else, and record again with all other axes at rest: {text}"


def other_things(result: Identification) -> tuple[str, ...]:
    """The other warnings, each once; what is not determined goes by the experiment that would determine it."""
    first = first_thing(result)
    unrelated = first is not None and first.startswith("Check")
    advised = first is not None and first.startswith(("Check", "Identify", "Take"))
    # A message that is part of the first thing is not said again.
    kept = [
        n
        for n in result.notices
        if n.code != "not_identifiable" and not (advised and n.code == "model_mismatch")
        and n.message.lower() not in (first or "").lower()
    ]  # fmt: skip
    said = tuple(_sentence(text) for text in told(kept))
    weak = [p.key for p in result.parameters if not p.identifiable]
    if unrelated and weak:
        return (*said, f"{_listed(weak)} not determined by this recording, as things are.")
    return (*said, *_undetermined(result, told(n for n in result.notices if n.code == "not_identifiable")))


def _undetermined(result: Identification, messages: tuple[str, ...]) -> tuple[str, ...]:
    """One line an experiment, the keys that it would determine named together."""
    keys: dict[str, list[str]] = {}
    unknown = []
    for message in messages:
        key = message.split(" ", 1)[0]
        how = EXPERIMENTS.get(key)
        if how is None or not any(p.key == key for p in result.parameters):
            unknown.append(message)
        else:
            keys.setdefault(how, []).append(key)
    return (*(f"{_listed(names)} not determined by this recording: {how}." for how, names in keys.items()), *unknown)


def _listed(names: list[str]) -> str:
    """`K is`, `K and JL are`."""
    if len(names) == 1:
        return f"{names[0]} is"
    return f"{', '.join(names[:-1])} and {names[-1]} are"


def _sentence(text: str) -> str:
    """The text with a capital at its start."""
    return text[:1].upper() + text[1:]
