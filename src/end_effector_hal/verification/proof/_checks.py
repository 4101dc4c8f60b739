"""Checks for every model that no query expresses: all can happen, time passes, channels and names are whole."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from end_effector_hal.errors import StoppedError
from timed_automata import Document, Network, make_network
from timed_automata.explore import CoverageReport, Explorer, Overview, ReactionBound, overview

from ._finding import Finding

CHECKS = {
    "ranges": "Every value stays in its range, every index in its array.",
    "locations": "Every location can be reached.",
    "edges": "Every edge can fire.",
    "channels": "Every channel has both ends.",
    "names": "No two constants name the same value of a type.",
    "room": "Every time-out that is executed is due D before its invariant ends it.",
    "time": "Time can always pass: no timelock, and no endless run in finite time.",
}
"""Checks that are no requirements of a file: sentences by id."""
_NO_TIMELOCK = "timelock", "Nowhere is time stopped: no timelock."
_KEPT: dict[bytes, CoverageReport] = {}
"""Cached coverage of files with their own constants, by their complete content."""
_MOST_KEPT = 4


def checks(
    explorer: Explorer, found: Overview, reaction: ReactionBound | None = None, *, flickers: bool = False
) -> tuple[Finding, ...]:
    """Return the findings of one network after the exploration ``found``; decided ones have zero states and seconds.

    ``flickers``: divergence of time is not checked, only timelocks.

    Raises:
        RunTimeError: a value leaves its range.
    """
    missing = found.coverage
    faults = (missing.locations, missing.edges, found.open_channels, found.equal_names, found.late)
    *others, (id_, sentence) = _asked(reaction, flickers=flickers)
    nothing = (
        Finding(*asked, "", not each, 0, 0.0, "; ".join(each))
        for asked, each in zip(others, faults, strict=False)
    )
    found = replace(found, zeno=False) if flickers else found
    return (*nothing, _time(explorer, found, id_, sentence))


def _asked(reaction: ReactionBound | None, *, flickers: bool) -> list[tuple[str, str]]:
    """Return id and sentence of each check, that of time last; without a reaction bound there is no room to check."""
    asked = [(id_, CHECKS[id_]) for id_ in ("locations", "edges", "channels", "names")]
    if reaction is not None:
        asked.append(("room", CHECKS["room"].replace(" D ", f" D ({reaction.room} ms) ")))
    return [*asked, _NO_TIMELOCK if flickers else ("time", CHECKS["time"])]


def open_checks(reaction: ReactionBound | None, remark: str, *, flickers: bool) -> tuple[Finding, ...]:
    """Return the same findings as undecided, after an incomplete exploration; ``remark`` is the reason."""
    asked = _asked(reaction, flickers=flickers)
    return tuple(Finding(*each, "", False, 0, 0.0, remark, decided=False) for each in asked)


def without_unused(network: Network, found: Overview, progress: Callable[[int], None]) -> Overview:
    """Move edges that only the given constants make unreachable from the missing to the disabled ones.

    With the constants of the file itself these edges can fire. A tool with one step has no step before another one:
    the edges for that are not dead, but unneeded.
    """
    missing = found.coverage
    if not network.replaced or not (missing.edges or missing.locations):
        return found
    there = _own_coverage(network.document, progress)
    edges = tuple(edge for edge in missing.edges if edge in there.edges)
    locations = tuple(location for location in missing.locations if location in there.locations)
    unused = tuple(edge for edge in missing.edges if edge not in there.edges)
    return replace(found, coverage=CoverageReport(locations, edges, (*missing.disabled, *unused)))


def _own_coverage(document: Document, progress: Callable[[int], None]) -> CoverageReport:
    """Return the coverage with the constants of the file itself; it is the same for all tools, and explored once."""
    content = pickle.dumps(document)  # all of it, also of one that was edited since it was read
    if content not in _KEPT:
        if len(_KEPT) == _MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[content] = overview(make_network(document), [], progress).coverage
    return _KEPT[content]


def not_decided(error: StoppedError) -> str:
    """Return the remark of a finding whose exploration was stopped."""
    return f"not decided: {error}"


def _time(explorer: Explorer, found: Overview, id_: str, sentence: str) -> Finding:
    if not (found.stopped or found.zeno):
        return Finding(id_, sentence, "", True, 0, 0.0)
    begun, verdict = perf_counter(), None
    try:
        if found.stopped:
            verdict = explorer.timelock()
        if (verdict is None or verdict.holds) and found.zeno:
            verdict = explorer.zeno()
    except StoppedError as error:
        seconds = perf_counter() - begun
        return Finding(id_, sentence, "", False, 0, seconds, not_decided(error), decided=False)
    assert verdict is not None
    remark = "" if verdict.trace is None else verdict.trace.remark
    seconds = perf_counter() - begun
    return Finding(id_, sentence, "", not remark, verdict.states, seconds, remark, verdict.trace)
