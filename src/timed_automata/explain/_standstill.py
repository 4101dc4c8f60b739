"""Why nothing can happen any more, or time need not pass: what no query says, and the word ``deadlock``."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata.explain._judge import Judge
from timed_automata.explain._run import Stretch, told_time
from timed_automata.explain._watched import Subject, clock_subject, process_subject
from timed_automata.network import Trace


def held_up(judge: Judge) -> Iterator[tuple[str, tuple[Subject, ...]]]:
    """Of each process that may not stay where it is: which location, what bounds it, and what that speaks of."""
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
    """The moves of the cycle on which a run goes on without end."""
    seen = set()
    for step in trace.steps[trace.loop :] if trace.loop is not None else ():
        for edge in step.edges:
            process = judge.network.processes[edge.process]
            source, target = (process.locations[at].name for at in (edge.source, edge.target))
            words = f"{judge.names.element(process.name)} {source} → {target}"
            if words not in seen:
                seen.add(words)
                yield words, (process_subject(process.index),)
