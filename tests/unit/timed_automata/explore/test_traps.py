"""What a checker easily gets wrong (decision 1 of the design); each with a network of its own."""

from __future__ import annotations

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.sanity import sanity_check
from timed_automata.explore import Explorer, RunTimeError, verify

QUICK = "Q: {}: b | a -> b; do: n = 0 | b -> c"
TRAPS: list[tuple[str, tuple[str, ...], dict[str, bool]]] = [
    ("constants of the query enter the limits", ("clock x;", "P: a: x <= 7 | a -> a; guard: x >= 1; do: x = 0"),
     {"E<> x > 6": True, "E<> x > 7": False, "E<> x > 1000": False}),
    ("also where nothing else limits a clock", ("clock x;", "P: a -> a"), {"E<> x > 1000 && x < 1001": True}),
    ("limits hold back to where a clock is set and no further",
     ("clock x;", "P: b: x <= 3 | a -> b; do: x = 0 | b -> c | c -> d; guard: x >= 5 | d -> a"),
     # x is asked for where the network has forgotten it
     {"E<> P.d": True, "E<> P.b && x > 3": False, "A[] P.d imply x >= 5": True}),
    # Each round takes 1 of y's 5, so the state after it lies inside the one before; there are five rounds at most.
    ("inclusion would find cycles that are none",
     ("clock x, y;", "P: a: y <= 5 | a -> a; guard: x >= 1; do: x = 0 | a -> done; guard: y == 5"),
     {"A<> P.done": True, "E[] P.a": False}),
    ("time is never refused without a reason", ("clock x;", "P: locations: a"),
     {"E[] P.a": True, "A<> x >= 5": True, "A<> x < 0": False}),
    ("a timelock at 3 is an end", ("clock x;", "P: locations: a | a: x <= 3"),
     {"A<> x >= 5": False, "A<> x >= 3": True}),
    ("receivers of a broadcast must join",
     ("broadcast chan c; int[0,1] i;", "S: a -> b; sync: c!", "R: a -> b; sync: c?",
      "Shut: a -> b; guard: i == 1; sync: c?"),
     {"E<> S.b && R.a": False, "A[] S.b imply R.b && Shut.a": True}),
    ("a broadcast without receivers is sent and a handshake waits",
     ("broadcast chan all; chan one;", "A: a -> b; sync: all!", "B: a -> b; sync: one!"),
     {"E<> A.b": True, "E<> B.b": False}),
    ("no time in urgent locations", ("clock x;", "P: urgent: b | a -> b; do: x = 0 | b -> c"),
     {"E<> P.b && x > 0": False, "E<> P.c && x > 0": True}),
    ("no time in committed locations", ("clock x;", "P: committed: b | a -> b; do: x = 0 | b -> c"),
     {"E<> P.b && x > 0": False, "E<> P.c && x > 0": True}),
    ("only committed processes move", ("int[0,1] n;", QUICK.format("committed"), "O: a -> a; do: n = 1"),
     {"E<> Q.b && n == 1": False}),
    ("others move beside an urgent one", ("int[0,1] n;", QUICK.format("urgent"), "O: a -> a; do: n = 1"),
     {"E<> Q.b && n == 1": True}),
    ("an update out of range that no run reaches is none",
     ("clock x; int[0,2] n;", "P: a: x <= 4 | a -> a; guard: x >= 5; do: n = n + 3 | a -> b; guard: x >= 2"),
     {"A[] n == 0": True}),
    ("a transition into a violated invariant is disabled",
     ("clock x; int[0,1] n;", "P: b: x <= 1 | c: n == 1 | a -> b; guard: x >= 2 | a -> c; guard: x >= 2"),
     {"A[] P.a": True, "A[] not deadlock": False}),
]  # fmt: skip


@pytest.mark.parametrize(("model", "answers"), [each[1:] for each in TRAPS], ids=[each[0] for each in TRAPS])
def test_trap(model: tuple[str, ...], answers: dict[str, bool]) -> None:
    explorer = Explorer(network(*model))
    assert {query: explorer.check(query).holds for query in answers} == answers


def test_a_deadlock_that_only_the_coarser_widening_has() -> None:
    # Below the upper limit nothing asks for a lower bound of x: ExtraLU+ lets x be 3 in b, where b would be stuck.
    template = "P: a: x <= 2 | urgent: b | a -> b | b -> a; guard: x <= 2; do: x = 0"
    explorer = Explorer(network("clock x;", template))
    assert explorer.check("A[] not deadlock").holds
    assert sanity_check(explorer.network).ok is False  # a and b can alternate in no time
    assert sanity_check(explorer.network).deadlock is None
    late = "P: a: x <= 3 | urgent: b | a -> b | b -> a; guard: x <= 2; do: x = 0"
    verdict = verify(network("clock x;", late), "A[] not deadlock")
    assert not verdict.holds
    assert verdict.trace.end > 2


def test_liveness_does_not_ask_time_to_diverge() -> None:
    explorer = Explorer(
        network("clock x; int[0,1] n;", "P: a: x <= 1 | a -> a; do: n = 1 - n | a -> b; guard: x == 1")
    )
    verdict = explorer.check("A<> P.b")
    assert not verdict.holds  # round and round at time 0
    assert verdict.trace.loop is not None
    assert verdict.trace.end == 0
    survey = sanity_check(explorer.network)
    assert survey.timelock is None
    assert survey.zeno is not None
    assert not survey.diverges


def test_urgent_channels_stop_time_only_when_both_ends_are_ready() -> None:
    sender = "S: a: x <= 3 | a -> b; guard: x >= 3; do: x = 0 | b -> c; sync: now!"
    receiver = "R: a -> b; guard: y >= 5 | b -> c; sync: now?"
    explorer = Explorer(network("clock x, y; urgent chan now;", sender, receiver))
    assert explorer.check("E<> S.b && R.a && x > 1").holds
    assert explorer.check("sup{S.b && R.b}: x").extremes[0].value is None  # R may come as late as it likes
    prompt = "R: a -> b; guard: y >= 5; do: y = 0 | b -> c; sync: now?"
    assert verify(
        network("clock x, y; urgent chan now;", sender, prompt), "A[] S.b && R.b imply y <= 0"
    ).holds


def test_a_value_out_of_range_is_an_error_with_its_trace() -> None:
    counter = "P: a: x <= 4 | a -> a; guard: x >= 2; do: n = n + 1, x = 0"
    explorer = Explorer(network("clock x; int[0,2] n;", counter))
    for query in ("A[] true", "A[] not deadlock", "A<> n == 7", "E[] n < 3", "n == 1 --> n == 7", "sup: x"):
        with pytest.raises(RunTimeError, match="n = 3 is out of its range") as error:
            explorer.check(query)
        assert error.value.where.startswith("model.xml:1:")
        assert error.value.code == "EE-301"
        assert [step.at for step in error.value.trace.steps] == [2, 4]
        assert error.value.trace.end == 6
    with pytest.raises(RunTimeError):
        sanity_check(explorer.network)


def test_an_unconditional_update_out_of_range_is_found_though_no_time_passes() -> None:
    with pytest.raises(RunTimeError, match="out of its range"):
        verify(network("int[0,2] n;", "P: a -> a; do: n = n + 1"), "A[] true")


def test_an_index_out_of_range_in_a_guard_is_an_error_with_its_trace() -> None:
    template = "P: a -> b; do: i = 2 | b -> c; guard: v[i] == 0"
    with pytest.raises(RunTimeError, match="Index 2") as error:
        verify(network("int[0,2] i; int[0,1] v[2];", template), "A[] true")
    assert len(error.value.trace.steps) == 1


def test_a_timelock_hides_behind_an_edge_that_is_always_enabled() -> None:
    # "cancel" is always possible, so there is no deadlock; but x <= 3 and x >= 4 never meet.
    explorer = Explorer(
        network(
            "clock x; int[0,1] n;",
            """P: work: x <= 3
        work -> done; guard: x >= 4; do: x = 0
        done -> work; do: x = 0
        work -> work; do: n = 1""",
        )
    )
    assert explorer.check("A[] not deadlock").holds
    survey = sanity_check(explorer.network)
    assert survey.deadlock is None
    assert survey.coverage.locations == ("P.done",)
    assert len(survey.coverage.edges) == 2
    assert survey.zeno is not None


def test_an_initial_state_outside_of_its_invariant_is_refused() -> None:
    template = "P: a: n == 1 | a -> a"
    with pytest.raises(ModelError, match="initial state"):
        verify(network("int[0,1] n;", template), "A[] true")


def test_clocks_set_to_other_values_than_zero() -> None:
    template = "P: b: x <= 8 | a -> b; do: x = 3 + n | b -> c; guard: x >= 7"
    explorer = Explorer(network("clock x, t; int[0,2] n = 1;", template))
    assert explorer.check("inf{P.b}: x").extremes[0].value == 4
    assert explorer.check("inf{P.c}: t").extremes[0].value == 3
    assert explorer.check("sup{P.b}: x").extremes[0].value == 8


def test_arrays_of_clocks_by_a_computed_index() -> None:
    template = "P: a: x[i] <= 3 + i && t <= 9 | a -> a; guard: x[i] >= 2; do: x[i] = 0, i = 1 - i, t = 0"
    explorer = Explorer(network("clock x[2], t; int[0,1] i;", template))
    assert explorer.check("sup: x[1]").extremes[0].value == 4
    assert explorer.check("A[] not deadlock").holds is False  # x[1] may be past 4 when its turn comes


def test_a_supremum_beyond_the_limits_is_not_taken_from_a_widened_zone() -> None:
    # At first x is exact up to 3 only; that y <= 3 keeps x below it then says 5, which y < 3 forbids.
    first = "P: a -> c; guard: y <= 2; do: y = 0"
    second = "Q: a: y < 3 | a -> a; guard: y > 0 && x == 0"
    (extreme,) = verify(network("clock x, y;", first, second), "sup{y <= 3}: x").extremes
    assert (extreme.value, extreme.attained) == (5, False)


def test_no_supremum_is_seen_although_an_invariant_keeps_the_clock_near_its_limit() -> None:
    # In a the clock is never more than 1 past the last round: each limit is passed by a little only, for ever.
    rounds = "P: a: y <= 1 | a -> b | b -> a; guard: y == 3; do: y = 0"
    verdict = verify(network("clock x, y;", rounds), "sup{P.a}: x")
    (extreme,) = verdict.extremes
    assert (extreme.value, extreme.attained) == (None, False)
    assert verdict.states < 100
