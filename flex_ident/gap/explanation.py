"""What an explanation of the gap says: steps, regions, findings, and what could not be tested."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from flex_ident.gap.measured import MeasuredCurve
from flex_ident.gap.reading import Reading
from flex_ident.gap.sizes import GapSize
from flex_ident.likelihood.repeats import Repeats
from flex_ident.notices import Code, Notice, Reason
from flex_ident.parameters import Identification, Parameter
from flex_ident.recording import Floats

GapVerdict = Literal["complete", "explained", "partly_explained", "unexplained", "rejected"]


@dataclass(frozen=True)
class Step:
    """A model of the search and the gap it leaves on data that its fit did not see, N m rms."""

    model: str
    gap: float
    link_gap: float | None = None
    """The same of the link's position, rad rms; None without a link encoder."""


@dataclass(frozen=True)
class Region:
    """Where the gap lies: `share` of its energy where `variable` is `low` to `high`, in `unit`, in `time_share` of the
    time; of the spectrum where it is the frequency."""

    variable: str
    low: float
    high: float
    share: float
    time_share: float
    unit: str


@dataclass(frozen=True)
class Profile:
    """The gap over one variable: bin centres (b,), mean (b,) and rms (b,) of the residual there, N m."""

    variable: str
    unit: str
    centre: Floats
    mean: Floats
    rms: Floats


@dataclass(frozen=True)
class Alternative:
    """Another effect that was considered at the same step, and the gap it would have left, N m."""

    effect: str
    gap_after: float


@dataclass(frozen=True)
class Proof:
    """What speaks for an effect: the gap `before` and `after` it on data not fitted, and what its trial said.

    `held_out_share` of the cost on left-out blocks is saved, `held_out_t` over blocks; `bic` falls; `share` of the
    closable gap is closed. `against`: what speaks against one that was put in by hand. `periods` within the range of
    motion of what is periodic in the motor's angle, where they are few; else None.
    """

    before: GapSize
    after: GapSize
    held_out_share: float
    held_out_t: float
    bic: float
    share: float
    against: Reason | None = None
    periods: float | None = None


@dataclass(frozen=True)
class Finding:
    """An effect that was accepted, or put in by hand."""

    effect: str
    verdict: Literal["accepted", "by_hand"]
    confidence: float
    gap_before: float
    gap_after: float
    parameters: tuple[Parameter, ...]
    proof: Proof
    also_considered: tuple[Alternative, ...] = ()
    indistinguishable_from: tuple[str, ...] = ()
    experiment: str = ""
    curve: MeasuredCurve | None = None
    """The law as it was measured, of an effect that is a table."""
    reading: Reading | None = None
    """Which named laws that one is closest to."""


@dataclass(frozen=True)
class Rejected:
    """A candidate that was not accepted, with the share of the gap's energy it would close, and why not.

    `promising` is False for one that was not worth a trial.
    """

    effect: str
    share: float
    reason: Reason
    promising: bool = True


@dataclass(frozen=True)
class Untestable:
    """An effect that this recording could not have shown, and the experiment that would."""

    effect: str
    orthogonal: float
    experiment: str


@dataclass(frozen=True)
class GapCurves:
    """Torque (m,), N m, over `time` (m,), s: measured, predicted by base and final model; `usable` rows (m,)."""

    time: Floats
    measured: Floats
    base: Floats
    final: Floats
    usable: Floats


@dataclass(frozen=True)
class GapExplanation:
    """The answer of `explain_gap`; `gap.json` is its public form."""

    joint: str
    sensors: str
    verdict: GapVerdict
    unit: str
    before: float
    after: float
    noise_floor: float
    steps: tuple[Step, ...]
    where: tuple[Region, ...]
    findings: tuple[Finding, ...]
    rejected: tuple[Rejected, ...]
    not_testable: tuple[Untestable, ...]
    final: Identification
    unexplained: tuple[Reason, ...] = ()
    """Why more is left than noise, or may be."""
    where_left: tuple[Region, ...] = ()
    repeats: Repeats | None = None
    repeats_left: Repeats | None = None
    notices: tuple[Notice, ...] = ()
    curves: GapCurves | None = None
    profiles: Mapping[str, tuple[Profile, Profile]] = field(default_factory=dict)
    """The gap over each variable, before and after."""
    method_error: float = 0.0
    """Gap, N m rms, that the method itself may leave: integration, filters, the instants of reversals."""

    @property
    def determined(self) -> bool:
        """Whether the recording determines the model at all; where it does not, no number may be trusted."""
        return self.verdict != "rejected" and all(n.code is not Code.BASE_NOT_DETERMINED for n in self.notices)

    @property
    def closed(self) -> float:
        """Share of the closable gap (above the noise floor, by energy) that the findings closed, 0 to 1."""
        closable = self.before**2 - self.noise_floor**2
        if closable <= 0.0:
            return 0.0
        return min(1.0, max(0.0, (self.before**2 - self.after**2) / closable))
