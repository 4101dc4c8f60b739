"""Cycles without time in any set of transitions, held against all choices of what a cycle leaves out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from types import MappingProxyType, SimpleNamespace
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.nightly import examples
from timed_automata.compiler import Bound
from timed_automata.explore.properties import _zeno
from timed_automata.explore.properties._zeno import zeno_cycle
from timed_automata.explore.search._cycles import components
from timed_automata.explore.states import Move
from timed_automata.explore.states._discrete import Action


class Step(NamedTuple):
    """A transition between numbered states: clocks tested for at least 1, and what clocks are set to."""

    source: int
    target: int
    tested: frozenset[int]
    resets: tuple[tuple[int, int], ...]


CLOCKS = st.integers(1, 3)
STEPS = st.builds(
    Step,
    st.integers(0, 4),
    st.integers(0, 4),
    st.frozensets(CLOCKS, max_size=2),
    st.lists(st.tuples(CLOCKS, st.sampled_from((0, 0, 0, 2))), max_size=2).map(tuple),
)


Entries = Mapping[int, frozenset[int]]
"""The clocks that the invariant of a state asks for at least 1."""


class Record(int):
    """A numbered state, and its invariant."""

    form: SimpleNamespace

    @classmethod
    def of(cls, number: int, entries: Entries) -> Record:
        record = cls(number)
        bounds = tuple(Bound(clock, ">=", 1) for clock in sorted(entries.get(number, ())))
        record.form = SimpleNamespace(entry=bounds)
        return record


def found_in(steps: Iterable[Step], entries: Entries = MappingProxyType({})) -> list[Any] | None:
    arcs = [(Record.of(s.source, entries), Record.of(s.target, entries), _move(s)) for s in steps]
    return zeno_cycle(arcs)  # type: ignore[arg-type]


def _move(step: Step) -> Move:
    guard = tuple(Bound(clock, ">=", 1) for clock in sorted(step.tested))
    return Move(Action((), None, guard, dict(step.resets)), None)


def exists(steps: Sequence[Step]) -> bool:
    """Whether a cycle leaves out, of each clock that it only sets to 0, all tests or all settings."""
    for choice in product(("tests", "settings", "neither"), repeat=3):
        kept = [
            step for step in steps if all(_allowed(step, clock, choice[clock - 1]) for clock in (1, 2, 3))
        ]
        graph: dict[int, list[int]] = {at: [] for at in range(5)}
        for step in kept:
            graph[step.source].append(step.target)
        for component in components(graph):
            inside = [step for step in kept if step.source in component and step.target in component]
            free = {clock for step in inside for clock, value in dict(step.resets).items() if value}
            if all(choice[clock - 1] != "neither" or clock in free for clock in (1, 2, 3)):
                return True
    return False


def _allowed(step: Step, clock: int, out: str) -> bool:
    return {
        "tests": clock not in step.tested,
        "settings": dict(step.resets).get(clock) != 0,
        "neither": True,
    }[out]


@settings(max_examples=examples(100, 5000), deadline=None)
@given(st.lists(STEPS, max_size=12), st.dictionaries(st.integers(0, 4), st.frozensets(CLOCKS, max_size=1)))
def test_a_cycle_is_found_where_there_is_one(steps: list[Step], entries: Entries) -> None:
    """An invariant tests what a step into it does not set."""
    found = found_in(steps, entries)
    asked = [
        step._replace(tested=step.tested | (entries.get(step.target, frozenset()) - dict(step.resets).keys()))
        for step in steps
    ]
    assert (found is not None) is exists(asked)
    if found is not None:
        assert [arc.target for arc in found] == [arc.source for arc in (*found[1:], found[0])]
        if not any(value for step in steps for _, value in step.resets):
            tested = {clock for arc in found for clock in arc.tested}
            assert tested.isdisjoint(clock for arc in found for clock in arc.zeroed)


@pytest.mark.thinned
def test_the_cost_is_linear_in_the_clocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten processes, each with a cycle that tests and sets its clock: to divide by each takes 2^10 searches."""
    steps, searches = [], 0

    def counted(graph: Mapping[int, Sequence[int]]) -> list[list[int]]:
        nonlocal searches
        searches += 1
        return components(graph)

    monkeypatch.setattr(_zeno, "components", counted)
    for state in product((0, 1), repeat=10):
        for process, at in enumerate(state):
            after = (*state[:process], 1 - at, *state[process + 1 :])
            tested = frozenset((process + 1,)) if at else frozenset[int]()
            resets = () if at else ((process + 1, 0),)
            steps.append(Step(_number(state), _number(after), tested, resets))
    assert found_in(steps) is None
    assert searches <= 1 + 2 * 10 + 1


def _number(state: tuple[int, ...]) -> int:
    return int("".join(map(str, state)), 2)
