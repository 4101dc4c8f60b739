"""Execution: what comes before what, and the windows of time in which edges can be taken."""

import pytest

from end_effector_hal.errors import ModelError, RangeError, UsageError
from tests.unit.timed_automata.explore.models import network
from timed_automata import Event, Execution

MS = 1000
BOTH = ("P", "Q")


def edges(steps):
    return [f"{edge.process}.{edge.source}>{edge.target}" for step in steps for edge in step.edges]


def run(declarations, *templates, executed=("P",), interface=(), system=""):
    execution = Execution(network(declarations, *templates, system=system), executed, interface)
    return execution, edges(execution.start(0))


def test_committed_steps_are_taken_at_the_start_and_after_an_event():
    execution, taken = run(
        "broadcast chan go;",
        "P: committed: A C | A -> B | B -> C; sync: go? | C -> D",
        "E: A -> A; sync: go!",
    )
    assert taken == ["P.A>B"]
    assert edges(execution.receive(Event("go"), 5).steps) == ["P.B>C", "P.C>D"]


def test_an_edge_without_a_clock_is_taken_at_once():
    assert run("", "P: A -> B")[1] == ["P.A>B"]


def test_committed_before_the_rest_then_system_line_then_file():
    parts = "P: A -> B | A -> C", "Q: committed: B | A -> B | B -> C", "R: committed: A | A -> B"
    _, taken = run("", *parts, system="system Q, P, R;", executed=["P", "Q", "R"])
    assert taken == ["R.A>B", "Q.A>B", "Q.B>C", "P.A>B"]


def test_what_is_due_first_comes_first_even_if_both_are_late():
    execution, _ = run("clock x;", "P: A -> B; guard: x >= 20", "Q: A -> B; guard: x >= 10", executed=BOTH)
    assert execution.deadline == 10 * MS
    steps = execution.advance(30 * MS)
    assert edges(steps) == ["Q.A>B", "P.A>B"]
    assert [(step.due, step.late_us) for step in steps] == [(10 * MS, 20 * MS), (20 * MS, 10 * MS)]


def test_broadcasts_among_the_executed_and_to_the_environment():
    execution, _ = run(
        "broadcast chan a; clock x; int n;",
        "W: A -> A; sync: a?",
        "Q(const int[0, 1] i): A -> B; guard: i == 1; sync: a?; do: n = n + 1",
        "P: A -> B; guard: x >= 3; sync: a!; do: n = 1",
        executed=BOTH,
    )
    (step,) = execution.advance(3 * MS)
    assert edges([step]) == ["P.A>B", "Q(1).A>B"]
    assert (step.sent, execution.value("n")) == ("a", 2)


def test_binary_channels_between_executed_processes():
    execution, taken = run(
        "chan c; clock x;", "P: A -> B; sync: c!", "Q: A -> B; guard: x >= 7; sync: c?", executed=BOTH
    )
    assert (taken, execution.deadline) == ([], 7 * MS)
    assert edges(execution.advance(7 * MS)) == ["P.A>B", "Q.A>B"]


def test_a_template_stands_for_all_its_processes_and_a_process_for_itself():
    model = {"system": "X = P(0); system P, X;"}
    parts = "", "P(const int[0, 2] i): A -> B"
    assert run(*parts, **model)[1] == ["P(0).A>B", "P(1).A>B", "P(2).A>B", "X.A>B"]
    assert run(*parts, **model, executed=["P(1)", "X"])[1] == ["P(1).A>B", "X.A>B"]
    with pytest.raises(UsageError, match="'Q' is neither a process nor a template"):
        run(*parts, **model, executed=["Q"])


# Windows of time ---------------------------------------------------------------------------------------------


def test_strict_bounds():
    execution, _ = run("clock x;", "P: A: x < 6 | A -> B; guard: x > 5")
    assert execution.deadline == 5 * MS + 1
    (step,) = execution.advance(6 * MS)
    assert (step.late_us, step.missed) == (999, True)


def test_a_window_that_never_opens_is_not_waited_for():
    execution, _ = run("clock x;", "P: A -> B; guard: x >= 5 && x < 5 | A -> B; guard: x >= 7 && x <= 7")
    assert execution.deadline == 7 * MS


def test_a_window_that_is_over_when_its_data_guard_comes_true():
    execution, _ = run(
        "broadcast chan go; int level; clock x;",
        "P: A -> B; guard: x <= 5 && level == 1",
        "E: A -> A; sync: go!; do: level = 1",
        interface=["level"],
    )
    assert not execution.receive(Event("go", {"level": 1}), 5 * MS + 1).steps
    assert execution.deadline is None


def test_lateness_does_not_close_a_window():
    execution, _ = run("clock x;", "P: A -> B; guard: x >= 3 && x <= 5")
    (step,) = execution.advance(9 * MS)
    assert (step.late_us, step.missed) == (6 * MS, True)


def test_a_target_whose_invariant_cannot_hold_disables_the_edge():
    execution, taken = run(
        "clock x;",
        """P: B: x <= 3 | C: x <= 2 | D: x <= 1
        A -> B; guard: x >= 4 | A -> C; guard: x >= 4; do: x = 3 | A -> D; guard: x >= 4; do: x = 1""",
    )
    assert taken == []
    assert edges(execution.run(9 * MS)) == ["P.A>D"]


def test_urgent_locations_wait_for_nothing():
    execution, taken = run("clock x;", "P: urgent: A | A -> B; guard: x >= 1 | A -> C; guard: x >= 0")
    assert (taken, execution.deadline) == ([], 0)
    assert edges(execution.advance(0)) == ["P.A>C"]


def test_an_edge_that_can_never_leave_an_urgent_location_is_not_waited_for():
    execution, _ = run("clock x;", "P: urgent: A | A -> B; guard: x >= 1")
    assert execution.deadline is None
    assert execution.advance(9 * MS) == ()


def test_an_edge_taken_again_is_due_anew():
    execution, _ = run("clock x; int n;", "P: A -> A; guard: x >= 1 && n < 3; do: n++")
    assert [(step.due, step.late_us) for step in execution.advance(9 * MS)] == [
        (1 * MS, 8 * MS), (9 * MS, 0), (9 * MS, 0)
    ]  # fmt: skip


def test_shared_clocks_and_clocks_set_to_a_number():
    execution, _ = run(
        "clock t; int n;",
        "P: A -> B; guard: t >= 10; do: t = 4 | B -> C; guard: t >= 10",
        "Q: A -> B; guard: t >= 12",
        executed=BOTH,
    )
    assert [(step.at, *edges([step])) for step in execution.run(99 * MS)] == [
        (10 * MS, "P.A>B"), (16 * MS, "P.B>C"), (18 * MS, "Q.A>B")
    ]  # fmt: skip


def test_an_invariant_that_cannot_be_evaluated_is_told_when_its_location_is_entered():
    execution, _ = run(
        "const int T[2] = {5, 5}; int i = 1; clock x;",
        "P: B: x <= T[i] | A -> B; guard: x >= 4; do: i = 2, x = 0",
    )
    assert execution.deadline == 4 * MS
    with pytest.raises(RangeError, match="Index 2 of 'T' is outside of 0 to 1"):
        execution.advance(4 * MS)


def test_the_unit_of_time_can_be_chosen():
    execution = Execution(network("clock x;", "P: A -> B; guard: x >= 2"), ["P"], unit_us=1_000_000)
    execution.start(5)
    assert execution.deadline == 2_000_005


# Levels ------------------------------------------------------------------------------------------------------

LEVEL = (
    "int[0, 3] evidence; broadcast chan changed; clock x;",
    "P: A -> B; guard: evidence == 3 | B -> A; guard: evidence == 0 && x >= 5",
    "E: A -> A; select: i : int[0, 3]; sync: changed!; do: evidence = i",
)


def test_levels_are_read_at_the_start():
    execution = Execution(network(*LEVEL), ["P"], ["evidence"])
    assert edges(execution.start(0, {"evidence": 3})) == ["P.A>B"]


def test_a_write_with_a_time_is_reacted_to_at_once():
    execution, _ = run(*LEVEL, interface=["evidence"])
    assert edges(execution.write({"evidence": 3}, 2 * MS)) == ["P.A>B"]
    assert execution.write({"evidence": 0}, 3 * MS) == ()
    assert execution.deadline == 5 * MS
    assert edges(execution.write({"evidence": 0}, 6 * MS)) == ["P.B>A"]


def test_a_write_without_a_time_waits_until_time_is_told():
    execution, _ = run(*LEVEL, interface=["evidence"])
    execution.advance(2 * MS)
    assert execution.write({"evidence": 3}) == ()
    assert execution.deadline == 2 * MS
    assert edges(execution.advance(2 * MS)) == ["P.A>B"]


def test_an_event_that_nobody_takes_still_writes_and_may_enable_an_edge():
    execution, _ = run(*LEVEL, interface=["evidence"])
    reaction = execution.receive(Event("changed", {"evidence": 3}), MS)
    assert not reaction.taken
    assert edges(reaction.steps) == ["P.A>B"]


# What never ends, and what gets stuck ------------------------------------------------------------------------


def test_a_livelock_is_told():
    with pytest.raises(ModelError, match="No end after 10000 steps at one instant: P never rest") as error:
        run("", "P: A -> B | B -> A")
    assert "model.xml" in error.value.where


def test_a_committed_location_without_a_way_on_is_told():
    with pytest.raises(ModelError, match="No edge leads on from the committed location 'A' of P"):
        run("int a;", "P: committed: A | A -> B; guard: a == 1")


def test_the_lateness_of_one_does_not_stop_another_in_a_committed_location():
    """Both are beyond their bounds: each goes its way to the end, and tells that it was late."""
    execution, _ = run(
        "clock x; clock y;",
        "P: committed: B | A: x <= 15 | A -> B; guard: x >= 10 | B -> C",
        "Q: A: y <= 16 | A -> B; guard: y >= 11",
        executed=BOTH,
    )
    steps = execution.advance(40 * MS)
    assert [(step.edges[0].process, step.edges[0].target, step.missed) for step in steps] == [
        ("P", "B", True),
        ("P", "C", True),
        ("Q", "B", True),
    ]
