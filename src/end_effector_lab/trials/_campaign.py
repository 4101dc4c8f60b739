"""The state of a campaign: the runs that are kept, the coverage that they reached, and the case of the next run.

Run n is drawn from the seed, n, and the coverage of the first three quarters of the runs before it (`drawn_from`). So
the same seed gives the same runs, however many workers there are, and in any order of their ends.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from end_effector_hal.description import Description

from ._case import Case, case_from_json
from ._coverage import CoverageMap, Reached
from ._draw import CaseSource

LEAST_AHEAD = 16
"""Smallest number of runs that may be in progress before one of them must be finished."""
MOST_MOMENTS = 60
_Number = Annotated[int, Field(ge=0, lt=2**53)]


class _KeptReached(BaseModel):
    """Reached numbers of a `CoverageMap`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    edges: list[_Number]
    locations: list[_Number]
    pairs: list[_Number]


class KeptRun(BaseModel):
    """A run as a line of the file: with its case only if it failed or reached something new."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    run: _Number
    grips: _Number
    s: float = Field(ge=0, allow_inf_nan=False)
    case: dict[str, Any] | None = None
    moments: list[_Number] | None = Field(None, max_length=MOST_MOMENTS)
    new: _KeptReached | None = None
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
        return self.model_dump(exclude_none=True)


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

    def add(self, found: Mapping[str, Any], description: Description) -> None:
        """Add the next run in the form of the file."""
        grips, seconds = int(found["grips"]), float(found["s"])
        case = case_from_json(found["case"], description) if "case" in found else None
        if case is not None and "new" in found:
            new = self.reached.add(Reached.from_json(found["new"]))
            self.kept.append(
                KeptCase(case, tuple(found["moments"]), bool(new.edges or new.locations), self.runs)
            )
        if "failures" in found:
            self.failures += 1
        if case is not None:
            for what in found.get("failures", {}).values():
                self.kinds.setdefault(kind_of_failure(what), FailedRun(found["run"], case))
        self.runs += 1
        self.grips += grips
        self.seconds += seconds

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
