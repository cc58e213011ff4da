"""A simulator's recording of the same motion, beside what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.configuration.settings import Value
from flex_ident.errors import FlexIdentError
from flex_ident.gap.options import GapOptions
from flex_ident.gap.simulator import SimulatorGap, compared_with_simulator, simulator_content
from flex_ident.parameters import Parameter
from flex_ident.recording import Recording
from flex_ident.recording.names import at_home


@dataclass(frozen=True)
class BesideSimulator:
    """What a simulator has wrong, or why that cannot be told: the explanation of the measurement holds without it.

    Neither, where no simulator's recording was given.
    """

    gap: SimulatorGap | None = None
    failed: FlexIdentError | None = None

    @property
    def content(self) -> dict[str, Any]:
        """What it adds to `gap.json`."""
        if self.failed is not None:
            return {"simulated": {"failed": str(self.failed)}}
        return {} if self.gap is None else {"simulated": simulator_content(self.gap)}


def simulated_recording(values: Mapping[str, Value], selection: SignalSelection) -> Recording | None:
    """The recording of a simulator that was given, as the robot's are selected; None where there is none.

    A simulator speaks SI on the link side, whatever the robot's driver does. Raises FlexIdentError.
    """
    if not values["simulated"]:
        return None
    own = replace(selection, effort_scale=1.0, gear_ratio=1.0)
    return read_recording(at_home(str(values["simulated"])), own)


def beside_simulator(
    simulated: Recording | None, measured: Sequence[Parameter], shown: Sequence[str], options: GapOptions, sensors: str
) -> BesideSimulator:
    """The parameters and the effects that a measurement has shown, with those `sensors`, beside the simulator's."""
    if simulated is None:
        return BesideSimulator()
    try:
        return BesideSimulator(compared_with_simulator(simulated, measured, shown, options, sensors))
    except FlexIdentError as error:
        return BesideSimulator(failed=error)
