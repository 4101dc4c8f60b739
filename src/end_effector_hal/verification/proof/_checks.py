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

_LOCATIONS = "locations", "Every location can be reached."
_EDGES = "edges", "Every edge can fire."
_CHANNELS = "channels", "Every channel has both ends."
_NAMES = "names", "No two constants name the same value of a type."
_ROOM = "Every time-out that is executed is due D ({} ms) before its invariant ends it."
_TIME = "time", "Time can always pass: no timelock, and no endless run in finite time."
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
    room = () if reaction is None else (_nothing("room", _ROOM.format(reaction.room), found.late),)
    time = (
        _time(explorer, replace(found, zeno=False), *_NO_TIMELOCK)
        if flickers
        else _time(explorer, found, *_TIME)
    )
    return (
        _nothing(*_LOCATIONS, missing.locations),
        _nothing(*_EDGES, missing.edges),
        _nothing(*_CHANNELS, found.open_channels),
        _nothing(*_NAMES, found.equal_names),
        *room,
        time,
    )


def open_checks(reaction: ReactionBound | None, remark: str, *, flickers: bool) -> tuple[Finding, ...]:
    """Return the same findings as undecided, after an incomplete exploration; ``remark`` is the reason."""
    room = () if reaction is None else (("room", _ROOM.format(reaction.room)),)
    asked = (_LOCATIONS, _EDGES, _CHANNELS, _NAMES, *room, _NO_TIMELOCK if flickers else _TIME)
    return tuple(Finding(id_, sentence, "", False, 0, 0.0, remark, decided=False) for id_, sentence in asked)


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


def _nothing(id_: str, sentence: str, faults: tuple[str, ...]) -> Finding:
    """Return the finding that there are no faults of a kind."""
    return Finding(id_, sentence, "", not faults, 0, 0.0, "; ".join(faults))


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
