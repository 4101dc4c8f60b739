"""What a checker easily gets wrong (decision 1 of the design); each with a network of its own."""

from __future__ import annotations

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.sanity import sanity_check
from timed_automata.explore import Explorer, RunTimeError, verify


def test_constants_of_the_query_enter_the_limits() -> None:
    explorer = Explorer(network("clock x;", "P: a: x <= 7 | a -> a; guard: x >= 1; do: x = 0"))
    assert explorer.check("E<> x > 6").holds
    assert not explorer.check("E<> x > 7").holds
    assert not explorer.check("E<> x > 1000").holds
    free = Explorer(network("clock x;", "P: a -> a"))
    assert free.check("E<> x > 1000 && x < 1001").holds


def test_limits_hold_back_to_where_a_clock_is_set_and_no_further() -> None:
    explorer = Explorer(
        network("clock x;", "P: b: x <= 3 | a -> b; do: x = 0 | b -> c | c -> d; guard: x >= 5 | d -> a")
    )
    assert explorer.check("E<> P.d").holds
    assert not explorer.check("E<> P.b && x > 3").holds
    assert explorer.check("A[] P.d imply x >= 5").holds  # x is asked for where the network has forgotten it


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


def test_inclusion_would_find_cycles_that_are_none() -> None:
    # Each round takes 1 of y's 5, so the state after it lies inside the one before; there are five rounds at most.
    explorer = Explorer(
        network("clock x, y;", "P: a: y <= 5 | a -> a; guard: x >= 1; do: x = 0 | a -> done; guard: y == 5")
    )
    assert explorer.check("A<> P.done").holds
    assert not explorer.check("E[] P.a").holds


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


def test_staying_where_time_may_stop_but_need_not_pass_is_a_run() -> None:
    lone = Explorer(network("clock x;", "P: locations: a"))
    assert lone.check("E[] P.a").holds
    assert lone.check("A<> x >= 5").holds  # time is never refused without a reason
    assert not lone.check("A<> x < 0").holds
    bounded = Explorer(network("clock x;", "P: locations: a | a: x <= 3"))
    assert not bounded.check("A<> x >= 5").holds  # a timelock at 3
    assert bounded.check("A<> x >= 3").holds


def test_receivers_of_a_broadcast_must_join() -> None:
    sender = "S: a -> b; sync: c!"
    ready = "R: a -> b; sync: c?"
    shut = "Shut: a -> b; guard: i == 1; sync: c?"
    explorer = Explorer(network("broadcast chan c; int[0,1] i;", sender, ready, shut))
    assert not explorer.check("E<> S.b && R.a").holds
    assert explorer.check("A[] S.b imply R.b && Shut.a").holds


def test_a_broadcast_without_receivers_is_sent_and_a_handshake_waits() -> None:
    both = ["A: a -> b; sync: all!", "B: a -> b; sync: one!"]
    explorer = Explorer(network("broadcast chan all; chan one;", *both))
    assert explorer.check("E<> A.b").holds
    assert not explorer.check("E<> B.b").holds


@pytest.mark.parametrize("mark", ["urgent", "committed"])
def test_no_time_in_urgent_and_committed_locations(mark: str) -> None:
    template = f"P: {mark}: b | a -> b; do: x = 0 | b -> c"
    explorer = Explorer(network("clock x;", template))
    assert not explorer.check("E<> P.b && x > 0").holds
    assert explorer.check("E<> P.c && x > 0").holds


def test_only_committed_processes_move() -> None:
    quick = "Q: committed: b | a -> b; do: n = 0 | b -> c"
    other = "O: a -> a; do: n = 1"
    assert not verify(network("int[0,1] n;", quick, other), "E<> Q.b && n == 1").holds
    urgent = "Q: urgent: b | a -> b; do: n = 0 | b -> c"
    assert verify(network("int[0,1] n;", urgent, other), "E<> Q.b && n == 1").holds


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


def test_an_out_of_range_update_that_no_run_reaches_is_none() -> None:
    counter = "P: a: x <= 4 | a -> a; guard: x >= 5; do: n = n + 3 | a -> b; guard: x >= 2"
    assert verify(network("clock x; int[0,2] n;", counter), "A[] n == 0").holds


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


def test_a_transition_into_a_violated_invariant_is_disabled() -> None:
    template = "P: b: x <= 1 | c: n == 1 | a -> b; guard: x >= 2 | a -> c; guard: x >= 2"
    explorer = Explorer(network("clock x; int[0,1] n;", template))
    assert explorer.check("A[] P.a").holds
    assert not explorer.check("A[] not deadlock").holds


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
