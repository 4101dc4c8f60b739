"""Records the subjects of a query over a run: variables and locations as words, clocks as curves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from timed_automata.explain._judge import Judge
from timed_automata.explain._run import Stretch
from timed_automata.explain._syntax import instance, returned
from timed_automata.language import ast
from timed_automata.queries import bounds_of, called

_INSTANCES = 64  # of a quantifier that are looked at
_FLIPPED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "=="}


@dataclass(frozen=True, slots=True)
class WatchedState:
    """The course of a variable, or of the location of a process, over a run, with names for its values.

    Attributes:
        name: ``evidence[cups]``, ``Gripper``.
        changes: pairs of a time and the value from then on; the first is at the start.
        wrong: whether the part of the query that does not hold refers to it.
    """

    name: str
    changes: tuple[tuple[Fraction, str], ...]
    wrong: bool


@dataclass(frozen=True, slots=True)
class WatchedClock:
    """The course of a clock over a run.

    Attributes:
        name: ``Observer.x``.
        points: (time, value), to be joined by lines.
        limits: pairs of a comparison in words and the value that the clock is compared with.
        deadline: time at which it passed the limit in the part of the query that does not hold; None if it passed
            none.
        wrong: whether the part of the query that does not hold refers to it.
    """

    name: str
    points: tuple[tuple[Fraction, Fraction], ...]
    limits: tuple[tuple[str, int], ...]
    deadline: Fraction | None
    wrong: bool


@dataclass(frozen=True, slots=True)
class _Process:
    index: int


@dataclass(frozen=True, slots=True)
class _Variable:
    name: str


@dataclass(frozen=True, slots=True)
class _Clock:
    number: int
    limits: tuple[tuple[str, int], ...] = ()


Subject = _Process | _Variable | _Clock


def process_subject(index: int) -> Subject:
    """Return the location of a process as a subject."""
    return _Process(index)


def clock_subject(number: int, limit: str, value: int) -> Subject:
    """Return a clock and its limit as a subject."""
    return _Clock(number, ((limit, value),))


def watched(
    judge: Judge,
    run: Sequence[Stretch],
    conditions: Sequence[ast.Expression],
    wrong: Sequence[ast.Expression],
    more: Sequence[Subject] = (),
) -> tuple[WatchedState | WatchedClock, ...]:
    """Return the courses of everything that the conditions refer to, in order; ``judge`` is for the end of the run.

    ``wrong`` are the parts of the conditions that are violated; the subjects in ``more`` count as wrong, too.
    """
    subjects = dict.fromkeys((*(each for node in conditions for each in _subjects(judge, node)), *more))
    guilty = {each for node in wrong for each in _subjects(judge, node, indices=False)} | set(more)
    found: list[WatchedState | WatchedClock] = []
    for each in subjects:
        if isinstance(each, _Clock):
            found.append(_clock(judge, run, each, conditions, wrong, guilty=each in guilty))
        else:
            found.append(_state(judge, run, each, wrong=each in guilty))
    return tuple(found)


def _subjects(judge: Judge, node: object, *, indices: bool = True) -> Iterator[Subject]:
    """Yield the subjects of a part of a condition; ``indices``: also those that only occur in an index."""
    inside = partial(_subjects, judge, indices=indices)
    if isinstance(node, tuple):
        for each in node:
            yield from inside(each)
        return
    if not isinstance(node, ast.Name | ast.Member | ast.Index | ast.Call | ast.Quantified):
        if isinstance(node, ast.Node):
            for name in node.__dataclass_fields__:
                yield from inside(getattr(node, name))
        return
    if isinstance(node, ast.Quantified):
        low, high = bounds_of(judge.network, node.type)
        for value in range(low, min(high + 1, low + _INSTANCES)):
            yield from inside(instance(node, value))
    elif isinstance(node, ast.Call):
        yield from _read_by(judge, node)
        yield from inside(node.arguments)
    elif (clock := judge.clock(node)) is not None:
        yield _Clock(clock)
    elif (place := judge.location(node)) is not None:
        yield _Process(place[0])
    elif (variable := judge.variable(node)) is not None:
        yield _Variable(variable)
    if isinstance(node, ast.Index) and indices:
        yield from inside(node.index)


def _read_by(judge: Judge, node: ast.Call) -> Iterator[Subject]:
    """Yield what a function reads: the subjects of the expression that it returns, or else all variables that it
    reads.
    """
    inner = None if node.process else returned(judge.names.text.functions.get(node.name))
    if inner is not None:
        yield from _subjects(judge, inner)
        return
    reads = called(judge.network, node).effects.reads
    for name, offset in judge.network.offsets.items():
        if judge.network.variable(offset).name in reads:
            yield _Variable(name)


def _state(
    judge: Judge, run: Sequence[Stretch], subject: _Process | _Variable, *, wrong: bool
) -> WatchedState:
    network, names = judge.network, judge.names
    changes: list[tuple[Fraction, str]] = []
    for stretch in run:
        if isinstance(subject, _Process):
            process = network.processes[subject.index]
            value = process.locations[stretch.state.locations[subject.index]].name
        else:
            value = names.value(subject.name, stretch.state.values[network.offsets[subject.name]])
        if not changes or changes[-1][1] != value:
            changes.append((stretch.begun, value))
    name = network.processes[subject.index].name if isinstance(subject, _Process) else subject.name
    return WatchedState(names.element(name), tuple(changes), wrong)


def _clock(
    judge: Judge,
    run: Sequence[Stretch],
    clock: _Clock,
    conditions: Sequence[ast.Expression],
    wrong: Sequence[ast.Expression],
    *,
    guilty: bool,
) -> WatchedClock:
    number, points = clock.number, []
    for stretch in run:
        points += [(instant.at, instant.clock(number)) for instant in (stretch.entry, stretch.end)]
    limits = dict(clock.limits)
    limits |= {f"{op} {judge.bound(at)}": judge.number(at) for op, at in _limits(judge, number, conditions)}
    broken = [judge.number(at) for _, at in _limits(judge, number, wrong)]
    missed = [value for value in broken if value <= judge.instant.clock(number)]
    deadline = run[-1].set_at[number] + min(missed) if missed else None
    name = judge.names.element(judge.network.clocks[number])
    return WatchedClock(
        name, tuple(dict.fromkeys(points)), tuple(limits.items()), deadline, guilty or bool(broken)
    )


def _limits(
    judge: Judge, number: int, conditions: Sequence[ast.Expression]
) -> list[tuple[str, ast.Expression]]:
    """Return the comparisons of a clock: operator and limit."""
    found = []
    for node in (each for condition in conditions for each in ast.walk(condition)):
        if isinstance(node, ast.Binary) and node.op in _FLIPPED:
            for left, op, right in (
                (node.left, node.op, node.right),
                (node.right, _FLIPPED[node.op], node.left),
            ):
                if isinstance(left, ast.Name | ast.Member | ast.Index) and judge.clock(left) == number:
                    found.append((op, right))
    return found
