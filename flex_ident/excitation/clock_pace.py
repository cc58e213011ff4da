"""How fast time passes in the stamps of joint states: in that of a slow simulator a joint would move faster."""

from __future__ import annotations

LEAST_S, LONGEST_S = 1.0, 20.0
"""Time over which the pace is taken, at least and at most."""
UNEVEN_S, UNEVEN_SHARE = 0.3, 0.05
"""By how much it may fall behind: a pause of the machine or of the network, and a share of the time that has passed."""


class ClockPace:
    """Fed with the instant at which each joint state came, s of the steady clock, and its stamp, s."""

    def __init__(self) -> None:
        self._first = self._latest = (0.0, 0.0)
        self._known = False

    def restart(self) -> None:
        """Begin anew: the clock was set."""
        self._known = False

    def observe(self, received: float, stamp: float) -> None:
        """Take a joint state."""
        self._latest = (received, stamp)
        if not self._known or received - self._first[0] > LONGEST_S:
            self._first, self._known = self._latest, True

    @property
    def known(self) -> bool:
        """Whether joint states have come for long enough."""
        return self._known and self._latest[0] - self._first[0] >= LEAST_S

    def problem(self) -> str:
        """That the time of the joint states passes more slowly than real time; empty: not so far."""
        passed, its_own = self._latest[0] - self._first[0], self._latest[1] - self._first[1]
        if passed < LEAST_S or passed - its_own <= UNEVEN_S + UNEVEN_SHARE * passed:
            return ""
        return (
            f"the joint states' time passes at {its_own / passed:.2f} of real time, in which speeds and limits hold: "
            "run the simulator in real time, or see what holds them up."
        )
