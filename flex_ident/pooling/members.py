"""One recording's own result, as far as several are put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flex_ident.parameters import Covariance, Parameter, Verdict
from flex_ident.pooling.sessions import Sessions, sessions_of
from flex_ident.recording.recording import Floats


@dataclass(frozen=True)
class Member:
    """A recording by `name`, its parameters with their covariance, and the conditions under which it was made.

    `start_time_s`: when it began, since 1970; 0 where that is not known.
    """

    name: str
    parameters: tuple[Parameter, ...]
    covariance: Covariance
    conditions: Mapping[str, float | str] = field(default_factory=dict)
    verdict: Verdict = "trusted"
    start_time_s: float = 0.0

    @property
    def known(self) -> tuple[str, ...]:
        """Keys of the parameters that this recording determines."""
        return tuple(p.key for p in self.parameters if p.identifiable and p.key in self.covariance.keys)

    def value(self, key: str) -> float:
        """A parameter's value. Raises KeyError for one that is not there."""
        for p in self.parameters:
            if p.key == key:
                return p.value
        raise KeyError(key)


@dataclass(frozen=True)
class MemberValues:
    """The members' values (n, p) of `keys`, NaN where a recording does not determine one, their covariances (n, p, p),
    zero there, the standard deviations (n, p) that the method shares between recordings, and each one's session (n)."""

    keys: tuple[str, ...]
    values: Floats
    covariances: Floats
    systematic: Floats
    sessions: Sessions

    @property
    def there(self) -> NDArray[np.bool_]:
        """Where (n, p) a recording determines a parameter."""
        found: NDArray[np.bool_] = np.isfinite(self.values)
        return found


def side_by_side(members: Sequence[Member]) -> MemberValues:
    """All parameters that at least one of the members determines, in the order of the first that does."""
    keys = tuple(dict.fromkeys(key for m in members for key in m.known))
    shape = (len(members), len(keys))
    values, systematic = np.full(shape, np.nan), np.zeros(shape)
    covariances = np.zeros((*shape, len(keys)))
    for i, member in enumerate(members):
        own = [key for key in keys if key in member.known]
        at = [keys.index(key) for key in own]
        values[i, at] = [member.value(key) for key in own]
        covariances[i][np.ix_(at, at)] = member.covariance.of(own)
        systematic[i, at] = member.covariance.systematic[[member.covariance.keys.index(key) for key in own]]
    return MemberValues(keys, values, covariances, systematic, sessions_of([m.start_time_s for m in members]))
