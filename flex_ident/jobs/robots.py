"""A recording beside the description of its robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flex_ident.configuration.settings import Value
from flex_ident.errors import UsageError
from flex_ident.parameters.documents import DocumentError, text_of
from flex_ident.recording import Recording
from flex_ident.recording.names import at_home, path_text
from flex_ident.robot.weight import weight_on
from flex_ident.robot.xml import LARGEST


def description_of(values: Mapping[str, Value]) -> str | None:
    """The URDF that was named; None without one. Raises UsageError where it cannot be read."""
    if not values.get("urdf"):
        return None
    path = at_home(str(values["urdf"]))
    try:
        return text_of(path, LARGEST)
    except DocumentError as error:
        raise UsageError(f"--urdf {path_text(path)}: {error}") from error


def described(recording: Recording, description: str | None) -> Recording:
    """The recording with what hangs on its joint by a URDF; as it is without one. Raises UsageError."""
    if description is None:
        return recording
    weight = weight_on(description, recording.joint, recording.poses, moving=tuple(recording.others))
    return replace(recording, weight=weight)
