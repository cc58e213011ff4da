"""Where the signals of a joint are, by the settings.

Imports no more than that needs, so that a command that refuses its input does so at once.
"""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.bags.selection import SignalSelection
from flex_ident.configuration.settings import Value


def text_setting(values: Mapping[str, Value], key: str) -> str | None:
    """A setting that is a text; None where it is empty."""
    return str(values[key]) if values.get(key) else None


def names_in(text: object) -> tuple[str, ...]:
    """The names of a comma-separated list."""
    return tuple(n.strip() for n in str(text).split(",") if n.strip())


def signal_selection(values: Mapping[str, Value]) -> SignalSelection:
    """Which signals to read. Raises UsageError."""
    return SignalSelection(
        joint=text_setting(values, "joint"),
        motor_position=text_setting(values, "motor_position"),
        link_position=text_setting(values, "link_position"),
        effort=text_setting(values, "effort"),
        reference=text_setting(values, "reference"),
        motor_current=text_setting(values, "motor_current"),
        effort_scale=float(values["effort_scale"]),
        gear_ratio=float(values["gear_ratio"]),
        sensors=str(values["sensors"]),
        type_files=names_in(values.get("type_file", "")),
    )
