"""Positions of joints that turn without end, counted on where the reading wraps."""

from __future__ import annotations

import math
from dataclasses import replace

from flex_ident.excitation.joint_states import JointSample


class Turns:
    """Counts the turns of those joints that are `continuous`, the one that moves first, then those that hold."""

    def __init__(self, continuous: tuple[bool, ...]) -> None:
        self._continuous = continuous
        self._offsets: list[float] = []
        self._before: tuple[float, ...] = ()

    def restart(self) -> None:
        """Take the next reading as it is."""
        self._before = ()

    def near(self, positions: tuple[float, ...]) -> None:
        """Count on from positions, rad, whose turns have been counted: the next reading is within half a turn."""
        self._before, self._offsets = positions, [0.0] * len(positions)

    def unwrapped(self, sample: JointSample) -> JointSample:
        """The sample with positions that go on where readings jump by whole turns."""
        if sample.position is None or not any(self._continuous):
            return sample
        read = (sample.position, *sample.others)
        if len(self._before) != len(read):
            self._offsets = [0.0] * len(read)
            self._before = read
        for i, (now, then) in enumerate(zip(read, self._before, strict=True)):
            if i < len(self._continuous) and self._continuous[i] and math.isfinite(now - then):
                self._offsets[i] -= math.tau * round((now - then) / math.tau)
        self._before = tuple(n if math.isfinite(n) else b for n, b in zip(read, self._before, strict=True))
        position, *others = (value + offset for value, offset in zip(read, self._offsets, strict=True))
        return replace(sample, position=position, others=tuple(others))
