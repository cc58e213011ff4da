"""The link's motion under the terms a fit asks for: remembered where asked again, several simulated in one pass."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from flex_ident.likelihood.cores import mapped
from flex_ident.recording import Floats
from flex_ident.simulation.batch import LANES
from flex_ident.simulation.motion import MotorMotion
from flex_ident.simulation.response import LinkMotion, link_motion, link_motions
from flex_ident.simulation.terms import Term

MOTOR_SIDE = [int(t) for t in Term if not t.moves_link]
"""Terms that leave the link's motion as it is: no simulation is needed for their sensitivity."""
REMEMBERED = 4
"""The point of linearisation is asked for again and again."""


class LinkResponses:
    """Link motions (n,) along one motor motion, under vectors of terms; `filtered` is what a comparison makes of one.

    Safe to ask from several threads.
    """

    def __init__(self, motion: MotorMotion, filtered: Callable[[Floats, float], Floats]) -> None:
        self._motion = motion
        self._filter = filtered
        self._known: dict[bytes, LinkMotion] = {}
        self._filtered: list[tuple[LinkMotion, float, Floats]] = []
        self._lock = threading.Lock()

    def of(self, terms: Floats) -> LinkMotion:
        """The link's motion under `terms`."""
        moving = _moving(terms)
        found = self._recalled(moving)
        if found is None:
            found = link_motion(moving, self._motion)
            self._remember(moving, found)
        return found

    def of_many(self, many: Sequence[Floats]) -> list[LinkMotion]:
        """The same under each of several sets of terms, on all cores; only what moves the link anew is simulated."""
        moving = [_moving(terms) for terms in many]
        found = {terms.tobytes(): self._recalled(terms) for terms in moving}
        missing = {terms.tobytes(): terms for terms in moving if found[terms.tobytes()] is None}
        keys = list(missing)
        groups = [keys[i : i + LANES] for i in range(0, len(keys), LANES)]
        links = mapped(
            lambda group: link_motions([missing[k] for k in group], self._motion), groups,
            samples=self._motion.position.size,
        )  # fmt: skip
        for group, own in zip(groups, links, strict=True):
            found.update(zip(group, own, strict=True))
        ready = []
        for terms in moving:
            link = found[terms.tobytes()]
            assert link is not None
            ready.append(link)
        return ready

    def filtered_position(self, link: LinkMotion, skew: float) -> Floats:
        """The link's position (m,) as compared, `skew` s late; the last few are remembered."""
        with self._lock:
            for known, late, position in self._filtered:
                if known is link and late == skew:
                    return position
        position = self._filter(link.position, skew)
        with self._lock:
            self._filtered = [*self._filtered[1 - REMEMBERED :], (link, skew, position)]
        return position

    def _recalled(self, moving: Floats) -> LinkMotion | None:
        key = moving.tobytes()
        with self._lock:
            found = self._known.pop(key, None)
            if found is not None:
                self._known[key] = found
            return found

    def _remember(self, moving: Floats, link: LinkMotion) -> None:
        with self._lock:
            self._known[moving.tobytes()] = link
            while len(self._known) > REMEMBERED:
                self._known.pop(next(iter(self._known)))


def _moving(terms: Floats) -> Floats:
    moving = terms.copy()
    moving[MOTOR_SIDE] = 0.0
    if terms[Term.MOUNT_INERTIA] != 0.0:  # the motor's reaction moves the base
        moving[Term.MOTOR_INERTIA] = terms[Term.MOTOR_INERTIA]
    return moving
