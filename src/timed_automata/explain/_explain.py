"""Explains in one sentence why a run refutes a query."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from timed_automata.explain._judge import Judge
from timed_automata.explain._names import Names
from timed_automata.explain._run import Stretch, listed, stretches_of, told_time
from timed_automata.explain._watched import (
    Subject,
    WatchedClock,
    WatchedState,
    clock_subject,
    process_subject,
    watched,
)
from timed_automata.explain._words import Words
from timed_automata.language import ast
from timed_automata.network import Trace
from timed_automata.queries import Query


def held_up(judge: Judge) -> Iterator[tuple[str, tuple[Subject, ...]]]:
    """Yield an explanation and its subjects for every process that may not stay in its location."""
    network, instant = judge.network, judge.instant
    for process in network.processes:
        location = process.locations[instant.state.locations[process.index]]
        who = f"{judge.names.element(process.name)} may not stay in {location.name}"
        if location.committed or location.urgent:
            kind = "committed" if location.committed else "urgent"
            yield f"{who}, which is {kind}", (process_subject(process.index),)
        for constraint in location.invariant.clocks:
            bound = constraint.at(instant.state.values)
            clock, now = (
                judge.names.element(network.clocks[bound.clock]),
                told_time(instant.clock(bound.clock)),
            )
            limit = f"{bound.op} {told_time(bound.value)}"
            subjects = (process_subject(process.index), clock_subject(bound.clock, limit, bound.value))
            yield f"{who} beyond {clock} {limit} ({constraint.span.snippet}; it is {now})", subjects


def repeated(judge: Judge, run: list[Stretch], trace: Trace) -> Iterator[tuple[str, tuple[Subject, ...]]]:
    """Yield the moves of the cycle that a run repeats for ever."""
    seen = set()
    for step in trace.steps[trace.loop :] if trace.loop is not None else ():
        for edge in step.edges:
            process = judge.network.processes[edge.process]
            source, target = (process.locations[at].name for at in (edge.source, edge.target))
            words = f"{judge.names.element(process.name)} {source} → {target}"
            if words not in seen:
                seen.add(words)
                yield words, (process_subject(process.index),)


_MOST = 8  # facts that are told


@dataclass(frozen=True, slots=True)
class Explanation:
    """The reason why a run refutes a query.

    Attributes:
        sentence: the time, the facts that hold then, and the part of the query that is violated, with values by name.
        watched: the clocks and states that the query refers to, over the run.
    """

    sentence: str
    watched: tuple[WatchedState | WatchedClock, ...]


def explain(trace: Trace, query: Query, names: Names) -> Explanation:
    """Explain why a run refutes ``A[] p``, ``A<> p`` or ``p --> q``, or which value of ``sup`` or ``inf`` it shows.

    Args:
        trace: the run that a search for the query found.
        query: a query of the same network.
        names: names for the values of the network.
    """
    run = stretches_of(trace)
    if query.kind in ("sup", "inf"):
        judge = Judge(trace.network, names, run[-1].end, deadlock=False)
        return Explanation(
            f"At {told_time(trace.end)}: {trace.remark}.", watched(judge, run, query.targets, ())
        )
    conditions = [each for each in (query.condition, query.then) if each is not None]
    asked = conditions[-1]
    judge = Judge(trace.network, names, run[-1].end, deadlock=False)
    if judge.holds(asked):  # it is the deadlock that refutes it
        judge = Judge(trace.network, names, run[-1].end, deadlock=True)
    words = Words(judge)
    stuck = list(held_up(judge)) if judge.deadlock else []
    if query.kind == "A[]":
        sentence = _always(words, asked, told_time(trace.end))
    else:
        sentence = _eventually(words, query, run, trace, names)
    sentence += _told(stuck)
    more = [subject for _, subjects in stuck for subject in subjects]
    return Explanation(sentence, watched(judge, run, conditions, words.wrong, more))


def explain_time(trace: Trace, names: Names) -> Explanation:
    """Explain why time cannot pass at the end of a run, or why the cycle of a run takes no time."""
    run = stretches_of(trace)
    judge = Judge(trace.network, names, run[-1].end, deadlock=True)
    if trace.loop is None:
        found, sentence = list(held_up(judge)), f"At {told_time(trace.end)} {trace.remark}."
    else:
        found = list(repeated(judge, run, trace))
        sentence = f"At {told_time(trace.end)} this can go on for ever while no time passes."
    more = [subject for _, subjects in found for subject in subjects]
    return Explanation(sentence + _told(found), watched(judge, run, (), (), more))


def _told(found: Sequence[tuple[str, object]]) -> str:
    words = listed([each for each, _ in found], _MOST) if found else ""
    return f" {words}." if words else ""


def _always(words: Words, condition: ast.Expression, at: str) -> str:
    facts, then = words.parted(condition)
    return f"At {at} {listed(facts, _MOST)}: then {then}." if facts else f"At {at}: {then}."


def _eventually(words: Words, query: Query, run: list[Stretch], trace: Trace, names: Names) -> str:
    """Explain a run on which the expected condition never holds: since when it is due, and how the run goes on."""
    due, begun = query.condition if query.then is None else query.then, "From the start on"
    assert due is not None
    if query.then is not None and (start := _since(query, run, trace, names)) is not None:
        at, facts = start
        begun = f"At {told_time(at.begun)} {listed(facts, _MOST)}; from there on" if facts else begun
    end = f"at {told_time(trace.end)} {words.fault(due)}, and {trace.remark}"
    return f"{begun} this must come: {words.judge.text(due)}. It never does: {end}."


def _since(query: Query, run: list[Stretch], trace: Trace, names: Names) -> tuple[Stretch, list[str]] | None:
    """Return the first stretch where the left side holds and after which the right side never does, with facts."""
    found = None
    assert query.condition is not None
    assert query.then is not None
    for stretch in reversed(run):
        for instant in (stretch.end, stretch.entry):
            judge = Judge(trace.network, names, instant, deadlock=False)
            if judge.holds(query.then):
                return found
            if judge.holds(query.condition):
                found = stretch, Words(judge).facts(query.condition)
    return found
