"""`[BAG=]MASS@X[,Y]`: which known mass, kg, sits where, m, in which recording."""

from __future__ import annotations

import re
from collections.abc import Sequence

from flex_ident.errors import UsageError
from flex_ident.pooling.torque_scale import Load
from flex_ident.recording.names import shortened

_FORM = re.compile(r"(?:(?P<bag>.+)=)?(?P<mass>[^=@]+)@(?P<x>[^,@]+)(?:,(?P<y>[^,@]+))?$")
EXPECTED = "expected [BAG=]MASS@X[,Y], as in B=5.0@0.40"


def loads_in(texts: Sequence[str], names: Sequence[Sequence[str]]) -> list[Load] | None:
    """The load in each of the recordings, each known by any of its names; None where no text is given.

    A text without BAG is of every recording that none names. Raises UsageError, naming the text.
    """
    if not texts:
        return None
    common: Load | None = None
    own: dict[int, Load] = {}
    for text in texts:
        bag, load = _load(text)
        if bag is None:
            if common is not None:
                raise UsageError(f"--payload {shortened(text)}: a second one for all recordings: say of which, BAG=.")
            common = load
            continue
        meant = [i for i, known in enumerate(names) if bag in known]
        if len(meant) != 1:
            there = ", ".join(known[0] for known in names)
            raise UsageError(f"--payload {shortened(text)}: {bag!r} is none of the recordings: {there}.")
        if meant[0] in own:
            raise UsageError(f"--payload {shortened(text)}: a second one for {bag}: give one mass and its place.")
        own[meant[0]] = load
    carried = [own.get(i, common or Load()) for i in range(len(names))]
    if not any(load.mass > 0.0 for load in carried):
        raise UsageError(
            f"--payload {shortened(texts[0])}: no recording carries a mass: give it in kg, or leave this out."
        )
    if common is None and (empty := [i for i, load in own.items() if load.mass == 0.0]):
        raise UsageError(
            f"--payload for {names[empty[0]][0]}: a mass of 0 kg is what a recording without --payload carries: give "
            "its mass, or leave it out."
        )
    return carried


def _load(text: str) -> tuple[str | None, Load]:
    found = _FORM.match(text.strip())
    if found is None:
        raise UsageError(f"--payload {shortened(text)}: {EXPECTED}.")
    try:
        mass, x, y = (float(found[name] or 0.0) for name in ("mass", "x", "y"))
    except ValueError:
        raise UsageError(f"--payload {shortened(text)}: {EXPECTED}.") from None
    try:
        return found["bag"], Load(mass, x, y)
    except UsageError as error:
        raise UsageError(f"--payload {shortened(text)}: {error}") from None
