"""Several recordings of one joint, each explained by itself, then as one: which effects hold for the joint."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.bags.run_file import run_conditions
from flex_ident.configuration.settings import Value
from flex_ident.effects import CATALOGUE, effect_named
from flex_ident.errors import ExcitationError, FlexIdentError, UsageError
from flex_ident.gap import GapExplanation, explain
from flex_ident.gap.alike import aligned
from flex_ident.gap.carried import CarriedOver, carried_over
from flex_ident.gap.options import GapOptions
from flex_ident.gap.shared import Proposal, proposals
from flex_ident.gap.units import prismatic_explanation
from flex_ident.jobs.explaining import FinishedExplanation, Progress, finished_explanation
from flex_ident.jobs.options import gap_options
from flex_ident.jobs.payloads import loads_in
from flex_ident.jobs.places import Place
from flex_ident.jobs.sets import below, each_finished, left_out, one_folder, recording_names, texts_of, told_of
from flex_ident.jobs.several import joined_result, usable
from flex_ident.jobs.shared_effects import base_values, carried_from_others, its_own
from flex_ident.jobs.signals import signal_selection
from flex_ident.jobs.simulators import BesideSimulator, beside_simulator, simulated_recording
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Identification
from flex_ident.pooling.effects import STAYS, Heard, Outcome, dissenters, outcome_of
from flex_ident.recording import Recording
from flex_ident.report.gap_set_result import ITSELF, OTHERS, JoinedGap, RecordingGap, SetEffect, gap_set_content
from flex_ident.report.gap_set_writing import write_gap_set


@dataclass(frozen=True)
class FinishedGapSet:
    """The recordings' explanation together, `gap.json`'s content, and the files written, or why they were not."""

    result: JoinedGap
    content: dict[str, Any]
    paths: Mapping[str, Path]
    simulator: BesideSimulator
    """The joint beside a simulator's recording, if one was given."""
    unwritten: UsageError | None = None


def finished_gap_set(
    bags: Sequence[Path],
    values: Mapping[str, Value],
    place: Place,
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
) -> FinishedGapSet:
    """Explain each recording by itself, try on each what the others found, keep what holds, write.

    Each one's own explanation goes into a folder below. One that cannot be explained, or is rejected, is left out and
    named. Raises FlexIdentError; before anything is computed for wrong usage, and where fewer than two can be used.
    """
    place = one_folder(place)
    options = gap_options(values)
    simulated = simulated_recording(values, signal_selection(values))
    values = {**values, "simulated": ""}
    names, known = recording_names(bags)
    loads = loads_in(texts_of(values.get("payload", "")), known)
    asked = left_out(texts_of(values.get("leave_out", "")), known)
    conditions = [run_conditions(bag) for bag in bags]

    def one(bag: Path, name: str) -> FinishedExplanation:
        return finished_explanation(
            bag, values, below(place, name), plots=plots, read=read, progress=told_of(progress, name)
        )

    done, notices, first_error = each_finished(bags, names, asked, one)
    used = usable({i: _judged(own.raw) for i, own in done.items()}, names, notices, first_error)
    recordings = [done[i].recording for i in used]
    shared = SecondStage([names[i] for i in used], recordings, [done[i].raw for i in used], options, progress)
    effects, gaps, finals = shared.found()
    members = aligned([own.final for own in finals])
    joined = joined_result(
        shared.names, members, recordings, [conditions[i] for i in used],
        None if loads is None else [loads[i] for i in used], [*notices, *_notices(effects, shared.names)],
    )  # fmt: skip
    result = JoinedGap(joined, tuple(done[i].raw for i in used), tuple(finals), tuple(effects), tuple(gaps))
    folder, unwritten = place.found(recordings[0])
    content = gap_set_content(result)
    shown = [own.proposal.effect for own in result.accepted]
    simulator = beside_simulator(simulated, joined.found.parameters, shown, options, joined.sensors)
    content |= simulator.content
    paths: Mapping[str, Path] = {}
    if folder is not None:
        try:
            paths = write_gap_set(result, folder, content, plots=plots)
        except UsageError as error:
            if place.needed:
                raise
            unwritten = error
    return FinishedGapSet(result, content, paths, simulator, unwritten)


def _judged(explanation: GapExplanation) -> Identification:
    """The final identification, rejected where the explanation is."""
    final = explanation.final
    return replace(final, verdict="doubtful" if explanation.determined else "rejected")


class SecondStage:
    """The second stage: what each recording found is tried on the others."""

    def __init__(
        self, names: Sequence[str], recordings: Sequence[Recording], explanations: Sequence[GapExplanation],
        options: GapOptions, progress: Progress,
    ) -> None:  # fmt: skip
        self.names, self.recordings, self.explanations = names, recordings, explanations
        self.options, self.progress = options, progress
        self.results = aligned([own.final for own in explanations])
        every = proposals(explanations)
        self.own = [p for p in every if p.of_recording]
        self.proposed = [p for p in every if not p.of_recording]

    def found(self) -> tuple[list[SetEffect], list[RecordingGap], list[GapExplanation]]:
        """The effects, accepted ones first; each recording's gaps; and its explanation by what was accepted."""
        count = len(self.names)
        carried = [self._carried(i, self.proposed) for i in range(count)]
        heard = {p: [_heard(p, i, carried[i]) for i in range(count)] for p in self.proposed}
        put_in = self.options.add
        outcomes: dict[Proposal, Outcome] = {p: outcome_of(own, by_hand=p.effect in put_in) for p, own in heard.items()}
        accepted = [p for p in self.proposed if outcomes[p] in STAYS]
        finals = [self._final(i, accepted) for i in range(count)]
        gaps = [self._gap(i, accepted, carried[i], finals[i]) for i in range(count)]
        effects = [SetEffect(p, tuple(heard[p]), outcomes[p]) for p in self.proposed]
        for p in self.own:
            outcome = outcome_of([], of_recording=True, by_hand=p.effect in put_in)
            effects.append(SetEffect(p, tuple(Heard(own is not None) for own in p.findings), outcome))
        return sorted(effects, key=lambda e: not e.accepted), gaps, finals

    def _carried(self, i: int, effects: Sequence[Proposal], *, all_stay: bool = False) -> CarriedOver | None:
        """What the effects with the others' values do to recording `i`; None where the others found none of them."""
        tried = [c for p in effects if (c := carried_from_others(p, self.results, i)) is not None]
        if not tried:
            return None
        self.progress(f"trying the others' effects on {self.names[i]}", 0.0)
        own = [its_own(p, self.results[i]) for p in self.own if i in p.finders]
        starts = [base_values(self.results[j]) for j in (i, (i + 1) % len(self.names))]
        rigid = self.results[i].model.rigid
        try:
            found = carried_over(
                self.recordings[i], replace(self.options, rigid=rigid), own, tried,
                starts=starts, all_stay=all_stay,
            )  # fmt: skip
        except ExcitationError:
            return None
        self.progress(f"trying the others' effects on {self.names[i]}", 1.0)
        return found

    def _final(self, i: int, accepted: Sequence[Proposal]) -> GapExplanation:
        """The recording's explanation with what was accepted, and nothing else but what is its own."""
        explanation = self.explanations[i]
        wanted = [p for p in accepted if _makes_sense(p, self.results[i])]
        theirs = [p for p in self.proposed if i in p.finders]
        if set(theirs) == set(wanted):
            return explanation
        add = tuple(p.effect for p in (*wanted, *(o for o in self.own if i in o.finders)) for _ in range(p.times))
        self.progress(f"explaining {self.names[i]} again", 0.0)
        options = replace(
            self.options, add=add, effects=tuple(dict.fromkeys(add)), searching=False,
            rigid=self.results[i].model.rigid, staying=() if add else tuple(CATALOGUE),
        )  # fmt: skip
        try:
            found = explain(self.recordings[i], options)
        except FlexIdentError:
            return explanation
        self.progress(f"explaining {self.names[i]} again", 1.0)
        return prismatic_explanation(found) if options.prismatic else found

    def _gap(
        self, i: int, accepted: Sequence[Proposal], carried: CarriedOver | None, final: GapExplanation
    ) -> RecordingGap:
        floor = final.noise_floor
        known = [p for p in accepted if carried_from_others(p, self.results, i) is not None]
        if carried is not None and known and len(known) == len(accepted):
            kept = [s.effect for s in carried.steps if s.stays]
            if kept != [p.effect for p in known]:
                carried = self._carried(i, known, all_stay=True)
            if carried is not None:
                steps = (carried.base, *(s.after for s in carried.steps if s.stays))
                return RecordingGap(carried.base, carried.after, min(floor, carried.after), OTHERS, steps)
        last = final.after
        steps = (final.before, *(last for _ in accepted))
        return RecordingGap(final.before, last, min(floor, last), ITSELF, steps)


def _heard(proposal: Proposal, i: int, carried: CarriedOver | None) -> Heard:
    found = i in proposal.finders
    step = None
    if carried is not None and any(j != i for j in proposal.finders):
        step = next((s for s in carried.steps if s.effect == proposal.effect), None)
    if step is None:
        return Heard(found)
    return Heard(found, step.outcome, step.before, step.after if math.isfinite(step.after) else np.inf, step.t)


def _makes_sense(proposal: Proposal, result: Identification) -> bool:
    effect = effect_named(proposal.effect)
    return not (effect.needs_link and result.sensors == "motor") and not (effect.needs_spring and result.model.rigid)


def _notices(effects: Sequence[SetEffect], names: Sequence[str]) -> list[Notice]:
    """Which effects are not the joint's, and which recordings contradict one that is."""
    found = []
    for own in effects:
        others = ", ".join(names[i] for i in own.proposal.finders)
        against = dissenters(own.heard)
        name, contradicting = own.proposal.effect, ", ".join(names[i] for i in against)
        if not own.accepted:
            texts = {"case": own.outcome, "effect": name, "found": others, "against": contradicting}
            found.append(Notice(Code.EFFECT_NOT_SHARED, name, texts=texts))
        else:
            found += [Notice(Code.EFFECT_CONTRADICTED, names[i], texts={"effect": name}) for i in against]
    return found
