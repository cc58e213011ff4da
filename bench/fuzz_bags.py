"""Damaged and hostile bags, and files of each other kind that is read: what reading them ends in.

    python bench/fuzz_bags.py [--bags 500] [--files 200] [--identify 0] [--seed 0] [--jobs 2] [--kind TEXT]

Each of `--bags` bags (three storages, their compressions) is mutated and read in a worker with a limit of time and
memory; likewise `--files` files of each other kind. With `--identify N`, N further bags of a virtual joint are
identified as well, and each trusted result is compared with the truth. Counted: exceptions, hangs (over 30 s), memory
(over 1 GiB), silent losses (fewer messages than were recorded, and no notice), errors of more than one printable line,
and trusted parameters more than three standard deviations off. Exit status 1 when there is any. `--only I` repeats one
case, with its traceback; a case is a number that says the same mutation on any machine.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

from fuzz_cases import OTHERS, Outcome, bag_kinds, run_case

HANG_S = 30.0
ADDRESS_SPACE = 6 << 30


def work(connection: Any, bases: dict[str, Path]) -> None:
    """A worker's loop: cases in, outcomes out. A warning of numpy would reach the user: it is an exception here."""
    warnings.filterwarnings("error", category=RuntimeWarning)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    while True:
        task = connection.recv()
        if task is None:
            return
        connection.send(run_case(*task, bases))


class Worker:
    """A process that runs one case at a time, and is replaced when it hangs or dies."""

    def __init__(self, bases: dict[str, Path]) -> None:
        self._bases = bases
        self.task: tuple[str, int] | None = None
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(theirs, self._bases), daemon=True)
        self._process.start()
        theirs.close()
        self.since = time.monotonic()

    def give(self, task: tuple[str, int]) -> None:
        self.task, self.since = task, time.monotonic()
        self.connection.send(task)

    def taken(self) -> Outcome | None:
        """The outcome, when there is one; a worker that hangs or died gives a fault."""
        what, case = self.task or ("", 0)
        if self.connection.poll():
            try:
                outcome: Outcome = self.connection.recv()
                self.task = None
                return outcome
            except EOFError:
                fault = "killed"
        elif time.monotonic() - self.since > HANG_S * (1.0 if what != "identify" else 20.0):
            fault = "hang"
        else:
            return None
        self._process.kill()
        self._process.join()
        self._start()
        self.task = None
        return Outcome(case, what, "", fault, faults=[fault])

    def end(self) -> None:
        self.connection.send(None)
        self._process.join(5)


def run_all(tasks: list[tuple[str, int]], bases: dict[str, Path], jobs: int) -> list[Outcome]:
    """All outcomes; faults are printed as they are found."""
    workers = [Worker(bases) for _ in range(jobs)]
    outcomes: list[Outcome] = []
    left = tasks[::-1]
    while left or any(w.task for w in workers):
        for worker in workers:
            if worker.task is None and left:
                worker.give(left.pop())
        wait([w.connection for w in workers if w.task], timeout=1.0)
        for worker in workers:
            outcome = worker.taken() if worker.task else None
            if outcome is not None:
                outcomes.append(outcome)
                if outcome.kind.startswith("identified"):
                    off = f", largest error {max(outcome.off):.1f} standard deviations" if outcome.off else ""
                    print(f"case {outcome.case} ({outcome.mutation}): {outcome.ending}{off}", flush=True)
                if outcome.faults:
                    print(
                        f"{', '.join(outcome.faults)}: {outcome.kind}, case {outcome.case} ({outcome.mutation}), "
                        f"{outcome.lost} lost, {outcome.seconds:.1f} s, {outcome.mebibytes:.0f} MiB: "
                        f"{outcome.text.strip().splitlines()[-1:]}",
                        flush=True,
                    )
    for worker in workers:
        worker.end()
    return outcomes


def table(outcomes: list[Outcome]) -> str:
    """Endings and faults of each kind."""
    lines = [
        f"{'kind':28} {'cases':>6} {'read':>6} {'refused':>8} {'loss said':>10} {'slowest':>8} {'largest':>9}  faults"
    ]
    for kind in dict.fromkeys(o.kind for o in sorted(outcomes, key=lambda o: o.kind)):
        own = [o for o in outcomes if o.kind == kind]
        endings = Counter(o.ending for o in own)
        faults = Counter(fault for o in own for fault in o.faults)
        said = sum(o.lost > 0 and not o.faults for o in own)
        lines.append(
            f"{kind:28} {len(own):6} {len(own) - endings['refused'] - endings['exception']:6} {endings['refused']:8} "
            f"{said:10} {max(o.seconds for o in own):6.1f} s {max(o.mebibytes for o in own):5.0f} MiB  "
            f"{', '.join(f'{n} {fault}' for fault, n in faults.items()) or 'none'}"
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bags", type=int, default=500)
    parser.add_argument("--files", type=int, default=200, help="of each other kind")
    parser.add_argument("--identify", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kind", default="", help="only kinds of bags whose name holds this")
    parser.add_argument("--only", metavar="WHAT:CASE", help="bag:7, file:7 or identify:7")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fuzz_bases_") as folder:
        os.environ["TMPDIR"] = folder
        tempfile.tempdir = folder
        bases = {}
        for name, write in bag_kinds().items():
            if given.kind in name:
                place = Path(folder) / name.replace(" ", "_").replace(",", "")
                place.mkdir()
                bases[name], _ = write(place)
        if given.only:
            what, _, number = given.only.partition(":")
            outcome = run_case(what, int(number), bases)
            print(outcome.text, outcome, sep="\n")
            return int(bool(outcome.faults))
        first = given.seed
        tasks = [("bag", i) for i in range(first, first + given.bags)]
        tasks += [("file", i) for i in range(first, first + len(OTHERS) * given.files)]
        tasks += [("identify", i) for i in range(first, first + given.identify)]
        started = time.monotonic()
        outcomes = run_all(tasks, bases, given.jobs)
        left = [p.name for p in Path(folder).iterdir() if p.name.startswith(("fuzz_", "flex_ident_"))]
    print(table(outcomes))
    off = [error for o in outcomes for error in o.off]
    if off:
        trusted, within = sum(bool(o.off) for o in outcomes), sum(error <= 3.0 for error in off)
        print(f"{trusted} trusted results, {within} of {len(off)} parameters within three standard deviations")
    faults = Counter(fault for o in outcomes for fault in o.faults)
    print(
        f"{len(outcomes)} cases in {time.monotonic() - started:.0f} s: {sum(faults.values())} faults "
        f"({', '.join(f'{n} {fault}' for fault, n in faults.items()) or 'none'}); {len(left)} temporary files left"
    )
    return int(bool(faults or left))


if __name__ == "__main__":
    sys.exit(main())
