"""Labels in the units of a result: of a joint that slides, or of an effort that is a current."""

from __future__ import annotations

from collections.abc import Callable

from flex_ident.parameters import Identification
from flex_ident.parameters.current import is_current, unit_in_amperes
from flex_ident.parameters.prismatic import slides, unit_in_metres

Words = Callable[[str], str]
"""What puts a text with units into those of the joint."""


def as_they_are(text: str) -> str:
    """The texts of a revolute joint."""
    return text


def words_of(result: Identification) -> Words:
    """What puts a label into the units of a result."""
    metres: Words = unit_in_metres if slides(result) else as_they_are
    if not is_current(result.notices):
        return metres
    return lambda text: unit_in_amperes(metres(text)).replace("torque, A", "effort, A")
