"""What is executed is due so long before its invariant ends it as its reactions may be late, no less and no more."""

from __future__ import annotations

import pytest

from tests.unit.timed_automata.explore.models import Template, network
from timed_automata.explore import ReactionBound, overview

BOUND = ReactionBound(("P",), 5)


def late(
    invariant: str, *edges: str, executed: str = "P", other: str = "w -> w; sync: go!"
) -> tuple[str, ...]:
    made = network(
        "broadcast chan go; clock t; bool on; int[0, 9] n = 3;",
        Template(executed, [*edges, "b -> a; guard: t >= 20; do: t = 0"], invariants={"a": invariant}),
        Template("World", [other]),
    )
    return overview(made, [], reaction=BOUND).late


@pytest.mark.parametrize(
    ("invariant", "edge", "expected"),
    [
        ("t <= 15", "a -> b; guard: t >= 10", ()),
        ("t < 16", "a -> b; guard: t >= 10", ()),
        ("t <= 15", "a -> b; guard: t > 9", ()),
        ("t <= 15", "a -> b; guard: t >= 11", ("P.a: 4 instead of 5",)),
        ("t <= 16", "a -> b; guard: t >= 10", ("P.a: 6 instead of 5",)),
        ("t <= 15", "a -> b; guard: t >= 10; sync: go?", ("P.a: no edge is due",)),
        ("t <= 15", "a -> b; guard: t >= 10; sync: go!", ()),
        ("t <= 15", "a -> b; guard: t >= 10 && on", ("P.a: no edge is due",)),
        ("t <= 5 * n", "a -> b; guard: t >= 5 * n - 5", ()),
        ("t <= 15", "a -> b", ("P.a: 15 instead of 5",)),
    ],
)
def test_the_room_of_a_time_out(invariant: str, edge: str, expected: tuple[str, ...]) -> None:
    other = "w -> w" if "go?" in edge or "go" not in edge else "w -> w; sync: go?"
    if "go?" in edge:  # a receiver of a broadcast channel has no clock in its guard
        edge = edge.replace("guard: t >= 10; ", "")
    assert late(invariant, edge, other=other) == expected


def test_what_is_due_in_time_is_enough_also_where_something_else_may_happen_earlier() -> None:
    assert late("t <= 15", "a -> b; guard: t >= 10", "a -> b; guard: t >= 2") == ()


def test_the_environment_needs_none() -> None:
    assert late("t <= 15", "a -> b; guard: t >= 11", executed="Sensors") == ()
