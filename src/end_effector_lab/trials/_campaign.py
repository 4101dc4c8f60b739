"""A campaign: random cases, guided by what they reach, played on all workers.

Run n is drawn from the seed, n, and the coverage of the first three quarters of the runs before it (`drawn_from`). So
the same seed gives the same runs, however many workers there are, and in any order of their ends.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from end_effector_hal.cli import the_folder, write_whole
from end_effector_hal.description import Description
from end_effector_hal.recording import product_version
from end_effector_lab.results import append_line, new_results
from end_effector_lab.workers import ShippedAutomata, Workers

from ._case import Case
from ._coverage import CoverageMap, Reached
from ._draw import CaseSource, shrunk
from ._play import no_log, play_case

LEAST_AHEAD = 16
"""Smallest number of runs that may be in progress before one of them must be finished."""
MOST_MOMENTS = 60


class PlayedRun(NamedTuple):
    """A run; in the file its case stands only if it failed or reached something new."""

    run: int
    grips: int
    s: float
    case: Case | None
    moments: tuple[int, ...] = ()
    new: Reached | None = None
    failures: Mapping[str, str] | None = None

    def as_json(self) -> dict[str, Any]:
        """Return it as it stands in the file."""
        found = self._asdict() | {
            "case": self.case and self.case.as_json(),
            "new": self.new and self.new.as_json(),
        }
        if self.new is None:
            del found["moments"]
        return {key: value for key, value in found.items() if value is not None}


class KeptCase(NamedTuple):
    """A case that reached something new; mutants are made of it.

    Attributes:
        case, moments: the case, and the times at which something moved in it, µs.
        edge: whether an edge or a location was new, not only an edge with a fault.
        run: number of its run.
    """

    case: Case
    moments: tuple[int, ...]
    edge: bool
    run: int


class FailedRun(NamedTuple):
    """The first run with a kind of failure."""

    run: int
    case: Case


@dataclass
class Campaign:
    """The results of a campaign.

    Attributes:
        seed: seed of all cases.
        known, reached: everything that can be reached, and what was reached.
        runs, grips, seconds: number of runs, of successful grips, and seconds of virtual time.
        kept: the cases that are mutated.
        failures: number of runs that broke a rule.
        kinds: the first run of each kind of failure.
    """

    seed: int
    known: CoverageMap
    reached: Reached = field(default_factory=Reached)
    runs: int = 0
    grips: int = 0
    seconds: float = 0.0
    kept: list[KeptCase] = field(default_factory=list)
    failures: int = 0
    kinds: dict[str, FailedRun] = field(default_factory=dict)

    def add(self, found: PlayedRun) -> None:
        """Add the next run."""
        case = found.case
        if case is not None and found.new is not None:
            new = found.new.beyond(self.reached)
            self.reached.add(new)
            self.kept.append(KeptCase(case, found.moments, bool(new.edges or new.locations), self.runs))
        self.failures += found.failures is not None
        for what in (found.failures or {}).values():
            if case is not None:
                self.kinds.setdefault(kind_of_failure(what), FailedRun(found.run, case))
        self.runs += 1
        self.grips += found.grips
        self.seconds += found.s

    def may_draw(self, run: int) -> bool:
        """Return whether the runs that this one is drawn from are over."""
        return drawn_from(run) <= self.runs

    def draw(self, run: int, source: CaseSource) -> Case:
        """Return the case of a run."""
        kept = self.kept[: bisect_left(self.kept, drawn_from(run), key=lambda each: each.run)]
        random = Random(f"{self.seed} {run}")
        if not kept or random.random() < 0.3:
            return source.fresh(random)
        best = [each for each in kept if each.edge]
        one = random.choice(best if best and random.random() < 0.4 else kept)
        return source.mutant(random, one.case, one.moments, random.choice(kept).case)


def drawn_from(run: int) -> int:
    """Return the number of first runs that a run is drawn from."""
    return max(0, run - max(LEAST_AHEAD, run // 4))


def kind_of_failure(what: str) -> str:
    """Return the sentence of a failure without the numbers and times that differ from case to case."""
    return re.sub(r"\d+(\.\d+)?", "#", re.split(r" \(|, at [\d.]+ s$", what)[0])


def summary(campaign: Campaign) -> dict[str, Any]:
    """Return the figures, for one line of JSON; shares as ``reached/all``."""
    reached, known = campaign.reached, campaign.known
    return {
        "runs": campaign.runs,
        "failures": campaign.failures,
        "kinds": len(campaign.kinds),
        "grips": campaign.grips,
        "virtual_s": round(campaign.seconds),
        "edges": f"{len(reached.edges)}/{len(known.edges)}",
        "locations": f"{len(reached.locations)}/{len(known.locations)}",
        "edge_faults": f"{len(reached.pairs)}/{len(known.edges) * len(known.faults)}",
        "kept": len(campaign.kept),
        "seed": campaign.seed,
    }


def never_reached(campaign: Campaign) -> dict[str, Any]:
    """Return the edges and locations that no run has reached, and by fault the edges that no run took with it."""
    reached, known = campaign.reached, campaign.known
    by_fault = {
        fault: [
            name for edge, name in enumerate(known.edges) if known.pair(edge, number) not in reached.pairs
        ]
        for number, fault in enumerate(known.faults)
    }
    return {
        "edges": [name for number, name in enumerate(known.edges) if number not in reached.edges],
        "locations": [name for number, name in enumerate(known.locations) if number not in reached.locations],
        "edge_faults": by_fault,
    }


FAILURES, RUNS, UNREACHED = "failures", "runs.jsonl", "unreached.json"
MOST_KINDS = 40
"""Largest number of kinds of failures that are shrunk."""


class _Shared(NamedTuple):
    """The data that every worker needs."""

    described: Description
    automata: ShippedAutomata
    known: CoverageMap

    @property
    def description(self) -> Description:
        """The description with the automata as they are on the worker's machine."""
        return self.automata.of(self.described)


def run_campaign(
    description: Description,
    folder: Path,
    workers: Workers,
    *,
    seed: int,
    go_on: Callable[[Campaign, int], bool],
    on_progress: Callable[[Campaign], None] = lambda _: None,
) -> Campaign:
    """Play cases until ``go_on`` returns False, and write the smallest case of each kind of failure into ``failures``.

    Args:
        folder: a new one, which gets the results.
        workers: play the cases.
        seed: seed of all cases.
        go_on: called before each run with the results so far and the run's number.
        on_progress: called after each run.

    Raises:
        UsageError: the folder cannot be written, or is not empty; the tool cannot be played.
        WorkersError: the workers cannot be reached, or some cases were not played.
    """
    known, source = CoverageMap(description), CaseSource(description)
    campaign = Campaign(seed, known)
    campaign.reached.locations |= known.initial
    shared, over = _Shared(description, ShippedAutomata.read(description), known), False
    new_results(folder)
    on_progress(campaign)
    while not over:
        waiting: dict[int, PlayedRun] = {}
        todo = _Drawn(campaign, source, go_on)
        for _, found in workers.each(_play, shared, todo):
            waiting[found.run] = found
            while campaign.runs in waiting:
                line = _shortened(waiting.pop(campaign.runs), campaign)
                campaign.add(line)
                append_line(folder / RUNS, line.as_json())
                on_progress(campaign)
        over = todo.over
    _write_failures(campaign, folder / FAILURES, shared, workers)
    return campaign


class _Drawn:
    """Yields the next runs, as long as the results that they are drawn from are available."""

    def __init__(
        self, campaign: Campaign, source: CaseSource, go_on: Callable[[Campaign, int], bool]
    ) -> None:
        self._campaign, self._source, self._go_on = campaign, source, go_on
        self.over = False

    def __iter__(self) -> Iterator[tuple[int, Case]]:
        run = self._campaign.runs
        while self._campaign.may_draw(run):
            if not self._go_on(self._campaign, run):
                self.over = True
                return
            yield run, self._campaign.draw(run, self._source)
            run += 1


def _play(shared: _Shared, item: tuple[int, Case]) -> PlayedRun:
    """Play one run in a worker."""
    run, case = item
    with no_log():
        played = play_case(shared.description, case, shared.known)
    moments = tuple(played.moments[:MOST_MOMENTS])
    seconds, failures = round(played.tool.at / 1e6, 3), played.failures or None
    return PlayedRun(run, played.grips, seconds, case, moments, played.reached, failures)


def _shortened(found: PlayedRun, campaign: Campaign) -> PlayedRun:
    """Return the kept part of a run: its case only if it failed in a new way or reached something new."""
    new = (found.new or Reached()).beyond(campaign.reached)
    keeps = new or any(
        kind_of_failure(what) not in campaign.kinds for what in (found.failures or {}).values()
    )
    case = found.case if keeps else None
    return found._replace(case=case, new=new or None, moments=found.moments if new else ())


def _shrink(shared: _Shared, item: tuple[str, Case]) -> tuple[Case, list[str]]:
    """Return the smallest case of a kind of failure, and its log; runs in a worker."""
    kind, case = item
    description, known = shared.description, shared.known
    with no_log():
        smallest = shrunk(
            description, case, lambda failures: kind in map(kind_of_failure, failures.values()), known
        )
        return smallest, list(play_case(description, smallest, known).log())


def _write_failures(campaign: Campaign, folder: Path, shared: _Shared, workers: Workers) -> None:
    """Write a file for each kind of failure."""
    todo = [(kind, failed.case) for kind, failed in campaign.kinds.items()][:MOST_KINDS]
    if not todo:
        return
    the_folder(folder)
    description = shared.described
    numbers = {kind: number for number, kind in enumerate(campaign.kinds)}
    for (kind, _), (case, log) in workers.each(_shrink, shared, todo):
        failed = campaign.kinds[kind]
        document = {
            "tool": description.name, "description": description.fingerprint(), "version": product_version(),
            "kind": kind, "run": failed.run, "campaign_seed": campaign.seed,
            **case.as_json(), "words": case.words, "log": log,
        }  # fmt: skip
        path = folder / f"{numbers[kind] + 1:03}-{kind.partition(':')[0]}.json"
        write_whole(path, (json.dumps(document, indent=1) + "\n").encode())


def read_failures(folder: Path) -> list[dict[str, Any]]:
    """Return the contents of the failure files in order, each with its path as ``file``."""
    return [json.loads(path.read_bytes()) | {"file": str(path)} for path in sorted(folder.glob("*.json"))]
