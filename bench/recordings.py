"""Recordings of `plants` as the project's own."""

from __future__ import annotations

from typing import Any


def recording_of(recorded: Any, sensors: str) -> Any:
    """The project's own recording; without the link's position when `sensors` is the motor alone."""
    from flex_ident.recording import Recording

    return Recording(
        joint="joint", sample_rate_hz=recorded.rate_hz, motor_position=recorded.motor_position,
        motor_torque=recorded.motor_torque,
        link_position=recorded.link_position if sensors == "motor+link" else None,
    )  # fmt: skip
