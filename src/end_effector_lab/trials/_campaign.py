"""A campaign: random cases, guided by what they reach, played on all workers; a stopped one continues in its folder.

Run n is drawn from the seed, n, and the coverage of the first three quarters of the runs before it (`drawn_from`). So
the same seed gives the same runs, however many workers there are, and in any order of their ends.
"""

from __future__ import annotations

import json
import os
import re
from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from end_effector_hal.cli import the_folder, write_whole
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import product_version
from end_effector_lab.results import ResultsFolder, ResultsLayout, mark_of
from end_effector_lab.workers import ShippedAutomata, Workers

from ._case import LARGEST_BYTES, Case, case_from_json
from ._coverage import Count, CoverageMap, Reached
from ._draw import CaseSource, shrunk
from ._play import no_log, play_case

LEAST_AHEAD = 16
"""Smallest number of runs that may be in progress before one of them must be finished."""
MOST_MOMENTS = 60


class KeptRun(BaseModel):
    """A run as a line of the file: with its case only if it failed or reached something new."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    run: Count
    grips: Count
    s: float = Field(ge=0, allow_inf_nan=False)
    case: dict[str, Any] | None = None
    moments: list[Count] | None = Field(None, max_length=MOST_MOMENTS)
    new: Reached | None = None
    failures: dict[str, str] | None = Field(None, min_length=1)

    def misfit(self, run: int, known: CoverageMap) -> str:
        """Return what contradicts the number of the run, the tool, or itself; empty: nothing."""
        if self.run != run:
            return f"it is run {self.run}, and run {run} is the next one."
        useless = self.case is not None and self.new is None and self.failures is None
        if useless or (self.new is None) != (self.moments is None) or (self.new and self.case is None):
            return "a case, what it reached and its moments do not stand together."
        if self.new is not None:
            most = len(known.edges), len(known.locations), len(known.edges) * len(known.faults)
            found = self.new.edges, self.new.locations, self.new.pairs
            if any(max(numbers, default=-1) >= limit for numbers, limit in zip(found, most, strict=True)):
                return "it reached what this tool does not have."
        return ""

    def as_json(self) -> dict[str, Any]:
        """Return it as it stands in the file."""
        return self.model_dump(mode="json", exclude_none=True)


KEPT_RUN = TypeAdapter(KeptRun)


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

    def add(self, found: KeptRun, description: Description) -> None:
        """Add the next run."""
        case = None if found.case is None else case_from_json(found.case, description)
        if case is not None and found.new is not None:
            new = found.new.beyond(self.reached)
            self.reached.add(new)
            moments = tuple(found.moments or ())
            self.kept.append(KeptCase(case, moments, bool(new.edges or new.locations), self.runs))
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


FAILURES, UNREACHED = "failures", "unreached.json"
LAYOUT = ResultsLayout(
    "campaign", "campaign.json", "runs.jsonl",
    "Remove it and all lines behind it: their runs are played again.", (UNREACHED,), (FAILURES,),
)  # fmt: skip
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


class _Failure(BaseModel):
    """The fields of a failure's file that are read again; the others are kept unchanged."""

    model_config = ConfigDict(extra="allow")

    kind: str
    words: str


def campaign_folder(description: Description, folder: Path, seed: int) -> ResultsFolder:
    """Return the results folder of a campaign; raises UsageError if it cannot be used or belongs to other results."""
    return ResultsFolder(folder, LAYOUT, mark_of(description, seed=seed))


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
        folder: keeps the results; a campaign of the same seed continues there.
        workers: play the cases.
        seed: seed of all cases.
        go_on: called before each run with the results so far and the run's number.
        on_progress: called after each run.

    Raises:
        UsageError: the folder cannot be written, or contains another campaign; the tool cannot be played.
        WorkersError: the workers cannot be reached, or some cases were not played.
    """
    known, source = CoverageMap(description), CaseSource(description)
    campaign = Campaign(seed, known)
    campaign.reached.locations |= known.initial
    with campaign_folder(description, folder, seed) as results:
        for where, kept in results.lines(KEPT_RUN):
            _add_kept(kept, where, campaign, source, description, results)
        on_progress(campaign)
        shared, over = _Shared(description, ShippedAutomata.read(description), known), False
        while not over:
            waiting: dict[int, KeptRun] = {}
            todo = _Drawn(campaign, source, go_on)
            for _, found in workers.each(_play, shared, todo):
                waiting[found.run] = found
                while campaign.runs in waiting:
                    line = _shortened(waiting.pop(campaign.runs), campaign)
                    campaign.add(line, description)
                    results.append(line.as_json())
                    on_progress(campaign)
            over = todo.over
        _write_failures(campaign, folder / FAILURES, shared, workers)
    return campaign


def _add_kept(
    kept: KeptRun,
    where: str,
    campaign: Campaign,
    source: CaseSource,
    description: Description,
    results: ResultsFolder,
) -> None:
    """Add a run from the file; raise UsageError if it is not the next run of this campaign."""
    if wrong := kept.misfit(campaign.runs, campaign.known):
        raise results.misfit(wrong, where)
    if kept.case is not None:
        try:
            case = case_from_json(kept.case, description)
        except UsageError as error:
            raise results.misfit(str(error), where) from None
        if case != campaign.draw(kept.run, source):
            raise results.misfit(f"its case is not the one that seed {campaign.seed} gives.", where)
    campaign.add(kept, description)


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


def _play(shared: _Shared, item: tuple[int, Case]) -> KeptRun:
    """Play one run in a worker."""
    run, case = item
    with no_log():
        played = play_case(shared.description, case, shared.known)
    return KeptRun(
        run=run, grips=played.grips, s=round(played.tool.at / 1e6, 3), case=case.as_json(),
        moments=list(played.moments[:MOST_MOMENTS]), new=played.reached, failures=played.failures or None,
    )  # fmt: skip


def _shortened(found: KeptRun, campaign: Campaign) -> KeptRun:
    """Return the kept part of a run: its case only if it failed in a new way or reached something new."""
    new = (found.new or Reached()).beyond(campaign.reached)
    keeps = new or any(
        kind_of_failure(what) not in campaign.kinds for what in (found.failures or {}).values()
    )
    more = {"moments": found.moments, "new": new} if new else {"moments": None, "new": None}
    return found.model_copy(update=more if keeps else more | {"case": None})


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
    """Write a file for each kind of failure that has none yet."""
    done = {str(each["kind"]) for each in read_failures(folder)}
    todo = [(kind, failed.case) for kind, failed in campaign.kinds.items() if kind not in done][:MOST_KINDS]
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
        if os.path.lexists(path):
            raise UsageError(
                "This file is in the place of a failure report.", where=str(path), todo="Move it away."
            )
        write_whole(path, (json.dumps(document, indent=1) + "\n").encode())


def read_failures(folder: Path) -> list[dict[str, Any]]:
    """Return the contents of the failure files in order, each with its path as ``file``; raises UsageError for any
    other file.
    """
    found = []
    for path in sorted(folder.glob("*.json")):
        try:
            with path.open("rb") as file:
                document = _Failure.model_validate_json(file.read(LARGEST_BYTES), strict=True)
        except (OSError, ValidationError):
            raise UsageError(
                "This is not a failure report of a campaign.",
                where=str(path),
                todo="Move it away: it is written again.",
            ) from None
        found.append(document.model_dump() | {"file": str(path)})
    return found
