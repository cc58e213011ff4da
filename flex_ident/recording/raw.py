"""One number of each message as it lies in a bag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording.recording import Floats


@dataclass(frozen=True)
class RawSignal:
    """One number of each message as it lies in the bag: receive times (k,) and stamps (k,), ns, and values (k,).

    A stamp that is not set is 0. `source` says where it was found.
    """

    source: str
    received: NDArray[np.int64]
    stamps: NDArray[np.int64]
    values: Floats
