"""What no query says and every model must satisfy: all of it can happen, time goes on, channels have both ends."""

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
_ROOM = "Every time-out that is executed is due D ({} ms) before its invariant ends it."
_TIME = "time", "Time can always pass: no timelock, and no endless run in finite time."
_NO_TIMELOCK = "timelock", "Nowhere is time stopped: no timelock."
_KEPT: dict[bytes, CoverageReport] = {}
"""What was explored of whole files, by all that stands in them."""
_MOST_KEPT = 4


def checks(
    explorer: Explorer, found: Overview, reaction: ReactionBound | None = None, *, flickers: bool = False
) -> tuple[Finding, ...]:
    """Of one network, after the exploration ``found``; where that decides, states and seconds are zero.

    ``flickers``: that time diverges is not asked.

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
        *room,
        time,
    )


def open_checks(reaction: ReactionBound | None, remark: str, *, flickers: bool) -> tuple[Finding, ...]:
    """The same where the exploration did not come to its end; ``remark``: why."""
    room = () if reaction is None else (("room", _ROOM.format(reaction.room)),)
    asked = (_LOCATIONS, _EDGES, _CHANNELS, *room, _NO_TIMELOCK if flickers else _TIME)
    return tuple(Finding(id_, sentence, "", False, 0, 0.0, remark, decided=False) for id_, sentence in asked)


def without_unused(network: Network, found: Overview, progress: Callable[[int], None]) -> Overview:
    """Take what happens with the constants of the file itself for switched off by those that were given.

    A tool with one step has no step before another one: the edges for that are not dead, they are not needed.
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
    """What happens with the constants of the file itself: the same for each tool, so it is explored once."""
    content = pickle.dumps(document)  # all of it, also of one that was edited since it was read
    if content not in _KEPT:
        if len(_KEPT) == _MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[content] = overview(make_network(document), [], progress).coverage
    return _KEPT[content]


def not_decided(error: StoppedError) -> str:
    """The remark of what was stopped."""
    return f"not decided: {error}"


def _nothing(id_: str, sentence: str, faults: tuple[str, ...]) -> Finding:
    """That there are no such faults."""
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
