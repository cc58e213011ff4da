"""Which joints of a bag there is something to identify from."""

from __future__ import annotations

from pathlib import Path

from flex_ident.bags.motions import joint_motions
from flex_ident.errors import ExcitationError


def moving_joints(bag: Path) -> list[str]:
    """Every joint that moves, by name, once. Raises BagError and ExcitationError."""
    names = [m.name for m in joint_motions(bag) if not m.link and m.moves]
    if not names:
        raise ExcitationError(f"{bag}: no joint moved. Record while a joint follows a chirp.")
    return list(dict.fromkeys(names))
