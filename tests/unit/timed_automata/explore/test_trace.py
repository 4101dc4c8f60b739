"""Runs in absolute times, and in words."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from tests.unit.timed_automata.explore.classics import fischer
from tests.unit.timed_automata.explore.models import Template, network
from timed_automata import Trace
from timed_automata.explore import Verdict, verify


def trace(verdict: Verdict) -> Trace:
    assert verdict.trace is not None
    return verdict.trace


def test_a_counterexample_in_words() -> None:
    verdict = verify(fischer(2, wait="x >= 2"), "A[] not (P(1).cs && P(2).cs)")
    assert trace(verdict).lines == (
        "0 ms  P(1) idle → req",
        "0 ms  P(2) idle → req",
        "0 ms  P(1) req → wait  id 0 → 1",
        "2 ms  P(1) wait → cs",
        "2 ms  P(2) req → wait  id 1 → 2",
        "4 ms  P(2) wait → cs",
        "4 ms  not (P(1).cs && P(2).cs): does not hold",
    )


def test_channels_choices_and_changes_are_told() -> None:
    edge = "idle -> idle; select: n : int[1,2]; guard: x >= 10; sync: go[n]!; do: all += n, x = 0"
    sender = Template("Sender", [edge])
    sender.invariants = {"idle": "x <= 20"}
    receiver = Template("Receiver", ["off -> on; sync: go[2]?; do: last = all"])
    verdict = verify(
        network("clock x; broadcast chan go[3]; int[0,9] all, last;", sender, receiver), "E<> last == 3"
    )
    assert trace(verdict).lines == (
        "10 ms  go[1]: Sender stays in idle (n = 1)                     all 0 → 1",
        "20 ms  go[2]: Sender stays in idle (n = 2); Receiver off → on  all 1 → 3, last 0 → 3",
        "20 ms  last == 3: holds",
    )


def test_strict_bounds_give_fractions_as_round_as_they_can_be() -> None:
    template = Template("P", ["a -> b; guard: x > 1 && x < 2; do: y = 0", "b -> c; guard: x < 2 && y > 0"])
    run = trace(verify(network("clock x, y;", template), "E<> P.c"))
    first, second = (step.at for step in run.steps)
    assert 1 < first < second < 2
    assert (first, second) == (Fraction(6, 5), Fraction(7, 5))
    assert run.lines[0].startswith("1.2 ms")


def test_more_strict_bounds_than_any_round_margin_can_keep() -> None:
    edges = [f"s{n} -> s{n + 1}; guard: y > 0 && x < 1; do: y = 0" for n in range(20)]
    run = trace(verify(network("clock x, y;", Template("P", edges)), "E<> P.s20"))
    times = [step.at for step in run.steps]
    assert all(0 < earlier < later < 1 for earlier, later in pairwise(times))


def test_a_run_for_ever_says_where_it_returns_to() -> None:
    template = Template("P", ["a -> b; guard: x >= 3", "b -> c; do: x = 0", "c -> b; guard: x >= 1"])
    template.invariants = {"a": "x <= 5", "b": "x <= 5", "c": "x <= 2"}
    verdict = verify(network("clock x; bool never;", template), "A<> never")
    run = trace(verdict)
    assert run.loop is not None
    assert run.steps[-1].state.locations == (run.steps[run.loop - 1].state.locations if run.loop else (0,))
    assert run.lines[-1].endswith("repeats indefinitely")
    assert sum("↻" in line for line in run.lines) == len(run.steps) - run.loop


def test_a_leads_to_shows_the_moment_at_which_it_begins() -> None:
    template = Template("P", ["a -> b; do: x = 0", "b -> c; guard: x >= 7"])
    template.invariants = {"b": "x <= 9"}
    verdict = verify(network("clock x; bool never;", template), "P.b && x >= 4 --> never")
    assert not verdict.holds
    assert trace(verdict).end >= 4


def test_the_trace_of_a_supremum_reaches_it() -> None:
    template = Template("P", ["a -> b; guard: x >= 3; do: y = 0"], invariants={"a": "x <= 5", "b": "y <= 2"})
    verdict = verify(network("clock x, y;", template), "sup{P.b}: x")
    assert verdict.extremes[0].value == 7
    assert trace(verdict).end == 7
