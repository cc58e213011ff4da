"""What is likely behind the changes of one joint, from which parameters changed, which way and alike or not."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from enum import StrEnum

from flex_ident.effects.backlash import BACKLASH
from flex_ident.fleet.ratios import LOCKED, RATIOS, SHARES
from flex_ident.parameters.keys import key_text

FRICTION = ("FVm", "FSm", "FV", "FS")
LOAD = ("JL", "J", "MX", "MY")
INERTIAS = ("Jm", "JL", "J")
PLAY = key_text(BACKLASH.name, "gap")


class Cause(StrEnum):
    """A probable cause; `report/health_table.py` has the words."""

    EFFORT_SCALE = "effort_scale"
    GEAR_WEAR = "gear_wear"
    TRANSMISSION = "transmission"
    STIFFER = "stiffer"
    PAYLOAD = "payload"
    TEMPERATURE = "temperature"
    LUBRICATION = "lubrication"
    DRY_FRICTION = "dry_friction"
    OFFSET = "offset"
    SEVERAL = "several"
    VERSION = "version"


def probable_cause(
    changes: Mapping[str, tuple[float, float]], known: Collection[str], *, temperature: bool = False
) -> Cause:
    """The probable cause of relative changes, each with its standard deviation, by parameter.

    `known` are all parameters that were compared; `temperature` says that it was another in the recordings behind the
    change. A scale of the effort moves all that carry force alike; nothing else moves the motor's inertia.
    """
    changes = _by_parameters(changes)
    changed = set(changes)
    if _alike(changes, known):
        return Cause.EFFORT_SCALE
    if "K" in changed and changed <= {"K", "offset", *FRICTION, PLAY}:
        if changes["K"][0] > 0.0:
            return Cause.STIFFER
        worn = PLAY in changed and changes[PLAY][0] > 0.0
        return Cause.GEAR_WEAR if worn else Cause.TRANSMISSION
    if changed <= set(FRICTION):
        if temperature:
            return Cause.TEMPERATURE
        dry = changed <= {"FSm", "FS"} and all(change > 0.0 for change, _ in changes.values())
        return Cause.DRY_FRICTION if dry else Cause.LUBRICATION
    if changed <= {*LOAD, "offset"} and changed & set(LOAD):
        return Cause.PAYLOAD
    if changed == {PLAY}:
        return Cause.GEAR_WEAR
    return Cause.OFFSET if changed == {"offset"} else Cause.SEVERAL


def _by_parameters(changes: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """The changes without ratios of parameters: a ratio alone is put down to the parameter that it most likely is.

    K/JL changes with K where JL/Jm does not, else with JL.
    """
    own = {key: change for key, change in changes.items() if key not in RATIOS}
    locked, shares = changes.get(LOCKED), changes.get(SHARES)
    load = bool(set(LOAD) & set(own))
    if shares is not None and not load:
        own["JL"] = shares
    elif locked is not None and not load and "K" not in own:
        own["K"] = locked
    return own


def _alike(changes: Mapping[str, tuple[float, float]], known: Collection[str]) -> bool:
    """Whether stiffness, inertias and what else changed moved by one factor, of those that were compared all."""
    firm = [key for key in ("K", *INERTIAS) if key in known]
    if len(firm) < 2 and not (firm and set(FRICTION) & set(changes)):
        return False
    if not set(firm) <= set(changes):
        return False
    own = [changes[key] for key in changes if key != "offset"]
    middle = sum(change / std**2 for change, std in own) / sum(1.0 / std**2 for _, std in own)
    return all(abs(change - middle) < 3.0 * std for change, std in own)
