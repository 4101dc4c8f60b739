"""Play a campaign on all workers: random cases, guided by what they reach; a stopped one continues in its folder."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict, ValidationError

from end_effector_hal.cli import the_folder, write_whole
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import product_version
from end_effector_lab.results import ResultsFolder, ResultsLayout, mark_of
from end_effector_lab.workers import ShippedAutomata, Workers

from ._campaign import KEPT_RUN, MOST_MOMENTS, Campaign, KeptRun, kind_of_failure
from ._case import LARGEST_BYTES, Case, case_from_json
from ._coverage import CoverageMap, Reached
from ._draw import CaseSource, shrunk
from ._play import no_log, play_case

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
            waiting: dict[int, dict[str, Any]] = {}
            todo = _Drawn(campaign, source, go_on)
            for _, found in workers.each(_play, shared, todo):
                waiting[found["run"]] = found
                while campaign.runs in waiting:
                    line = _shortened(waiting.pop(campaign.runs), campaign)
                    campaign.add(line, description)
                    results.append(line)
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
    campaign.add(kept.as_json(), description)


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


def _play(shared: _Shared, item: tuple[int, Case]) -> dict[str, Any]:
    """Play one run in a worker."""
    run, case = item
    with no_log():
        played = play_case(shared.description, case, shared.known)
    return {
        "run": run, "grips": played.grips, "s": round(played.tool.at / 1e6, 3), "case": case.as_json(),
        "moments": list(played.moments[:MOST_MOMENTS]), "new": played.reached.as_json(),
        "failures": played.failures,
    }  # fmt: skip


def _shortened(found: dict[str, Any], campaign: Campaign) -> dict[str, Any]:
    """Return the kept part of a run: its case only if it failed in a new way or reached something new."""
    reached, seen = Reached.from_json(found["new"]), campaign.reached
    new = Reached(reached.edges - seen.edges, reached.locations - seen.locations, reached.pairs - seen.pairs)
    line: dict[str, Any] = {"run": found["run"], "grips": found["grips"], "s": found["s"]}
    kinds = map(kind_of_failure, found["failures"].values())
    if new or any(kind not in campaign.kinds for kind in kinds):
        line["case"] = found["case"]
    if new:
        line |= {"moments": found["moments"], "new": new.as_json()}
    if found["failures"]:
        line["failures"] = found["failures"]
    return line


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
