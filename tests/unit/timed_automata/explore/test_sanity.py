"""What is found in every model, asked for or not."""

from __future__ import annotations

import pytest

from tests.unit.timed_automata.explore.models import Template, network
from tests.unit.timed_automata.explore.sanity import SanityReport, sanity_check


def survey(declarations: str, *templates: Template, system: str = "") -> SanityReport:
    return sanity_check(network(declarations, *templates, system=system))


def loop(*edges: str, **more: object) -> Template:
    return Template("P", list(edges), **more)  # type: ignore[arg-type]


def test_a_sound_model_is_ok() -> None:
    found = survey(
        "clock x;",
        loop("a -> b; guard: x >= 1; do: x = 0", "b -> a", invariants={"a": "x <= 2", "b": "x <= 2"}),
    )
    assert found.ok
    assert found.diverges
    assert found.complete
    assert found.states == 2


def test_locations_and_edges_are_judged_by_template() -> None:
    cell = Template(
        "Cell",
        [
            "a -> b; guard: id == 1 && x >= 1; do: x = 0",
            "b -> a; guard: x >= 1; do: x = 0",
            "a -> c; guard: id == 2",
        ],
        parameters="const int[0,1] id",
        declarations="clock x;",
    )
    found = survey("int[0,1] n;", cell)
    assert found.coverage.locations == ("Cell.c",)
    assert [edge.partition(": ")[2] for edge in found.coverage.edges] == ["Cell a → c (id == 2)"]
    assert found.coverage.edges[0].startswith("model.xml:1:")


def test_channels_with_one_end() -> None:
    edges = ["a -> a; guard: x >= 1; sync: out[1]!; do: x = 0", "a -> a; sync: into?"]
    found = survey("clock x; broadcast chan out[2]; chan into, none;", loop(*edges))
    assert found.open_channels == (
        "out[0]: no edge uses it",
        "out[1]: no edge receives on it",
        "into: no edge sends on it",
        "none: no edge uses it",
    )
    assert not found.complete


def test_a_terminal_location_is_a_deadlock_and_no_timelock() -> None:
    found = survey("", loop("a -> b"))
    assert found.deadlock is not None
    assert found.timelock is None
    assert found.diverges


@pytest.mark.parametrize("more", [{"invariants": {"b": "x <= 2"}}, {"urgent": "b"}, {"committed": "b"}])
def test_where_time_cannot_go_on(more: dict[str, object]) -> None:
    found = survey("clock x;", loop("a -> b; do: x = 0", **more))
    assert found.timelock is not None
    assert found.timelock.lines[-1].endswith("no transition is possible, and time cannot go on")
    assert not found.diverges


def test_zeno_cycles() -> None:
    assert survey("", loop("a -> b", "b -> a")).zeno is not None
    assert survey("clock x;", loop("a -> b; do: x = 0", "b -> a")).zeno is not None  # set, not tested
    assert survey("clock x;", loop("a -> b; guard: x >= 1", "b -> a")).zeno is not None  # tested, not set
    assert survey("clock x;", loop("a -> b; guard: x > 0; do: x = 0", "b -> a")).zeno is not None  # converges
    assert survey("clock x;", loop("a -> b; guard: x >= 1", "b -> a; do: x = 0")).zeno is None
    assert (
        survey("clock x;", loop("a -> b; guard: x >= 1; do: x = 1", "b -> a")).zeno is not None
    )  # set to 1 is at least 1


def test_a_zeno_cycle_inside_a_larger_one() -> None:
    edges = ["a -> b; guard: x >= 1; do: x = 0", "b -> a", "b -> c; do: y = 0", "c -> b; guard: y >= 0"]
    found = survey("clock x, y;", loop(*edges))
    assert found.zeno is not None
    cycle = found.zeno.steps[found.zeno.loop :]
    assert {step.state.locations for step in cycle} == {(1,), (2,)}


def test_every_cycle_needs_its_own_clock() -> None:
    edges = ["a -> a; guard: x >= 1; do: x = 0", "a -> b; guard: y >= 2", "b -> a; do: y = 0"]
    assert survey("clock x, y;", loop(*edges)).zeno is None
    crossed = ["a -> b; guard: x >= 1", "b -> a; do: y = 0", "b -> c; guard: y >= 1", "c -> b; do: x = 0"]
    assert (
        survey("clock x, y;", loop(*crossed)).zeno is not None
    )  # a-b sets y, b-c sets x: neither what it tests


def test_counters_end_a_cycle() -> None:
    """The unwinding of a gripper goes through its steps in no time, but only once."""
    edges = [
        "a -> b; guard: x >= 1; do: k = 0, x = 0",
        "b -> b; guard: k < 3; do: k++",
        "b -> a; guard: k == 3",
    ]
    found = survey("clock x; int[0,3] k;", loop(*edges, committed="b"))
    assert found.zeno is None
    assert found.ok


def test_what_answers_is_driven_by_what_asks() -> None:
    asker = Template("A", ["a -> a; guard: x >= 1; sync: ask!; do: x = 0"])
    answerer = Template("B", ["a -> b; sync: ask?", "b -> a; sync: ask?"])
    assert survey("clock x; broadcast chan ask;", asker, answerer).ok
    ping = Template("A", ["a -> b; sync: ping!", "b -> a; sync: pong?"])
    pong = Template("B", ["a -> b; sync: ping?", "b -> a; sync: pong!"])
    assert survey("chan ping, pong;", ping, pong).zeno is not None
