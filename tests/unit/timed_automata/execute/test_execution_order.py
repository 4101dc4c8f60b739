"""Execution: what comes before what, and the windows of time in which edges can be taken."""

import pytest

from end_effector_hal.errors import ModelError, RangeError, UsageError
from timed_automata import Event, Execution

MS = 1000


def edges(steps):
    return [f"{edge.process}.{edge.source}>{edge.target}" for step in steps for edge in step.edges]


def run(load, text, executed=("P",), interface=(), at=0):
    execution = Execution(load(text), executed, interface)
    return execution, edges(execution.start(at))


def test_committed_steps_are_taken_at_the_start_and_after_an_event(load):
    execution, taken = run(
        load,
        """broadcast chan go; process P() { state A, B, C, D; commit A, C; init A; trans
        A -> B { }, B -> C { sync go? }, C -> D { }; } process E() { state A; init A; trans A -> A { sync go! }; }
        system P, E;""",
    )
    assert taken == ["P.A>B"]
    assert edges(execution.receive(Event("go"), 5).steps) == ["P.B>C", "P.C>D"]


def test_an_edge_without_a_clock_is_taken_at_once(load):
    _, taken = run(load, "process P() { state A, B; init A; trans A -> B { }; } system P;")
    assert taken == ["P.A>B"]


def test_committed_before_the_rest_then_system_line_then_file(load):
    _, taken = run(
        load,
        """
        process P() { state A, B, C; init A; trans A -> B { }, A -> C { }; }
        process Q() { state A, B, C; commit B; init A; trans A -> B { }, B -> C { }; }
        process R() { state A, B; commit A; init A; trans A -> B { }; }
        system Q, P, R;""",
        ["P", "Q", "R"],
    )
    assert taken == ["R.A>B", "Q.A>B", "Q.B>C", "P.A>B"]


def test_what_is_due_first_comes_first_even_if_both_are_late(load):
    execution, _ = run(
        load,
        """clock x; process P() { state A, B; init A; trans A -> B { guard x >= 20 }; }
        process Q() { state A, B; init A; trans A -> B { guard x >= 10 }; } system P, Q;""",
        ["P", "Q"],
    )
    assert execution.deadline == 10 * MS
    steps = execution.advance(30 * MS)
    assert edges(steps) == ["Q.A>B", "P.A>B"]
    assert [(step.due, step.late_us) for step in steps] == [(10 * MS, 20 * MS), (20 * MS, 10 * MS)]


def test_broadcasts_among_the_executed_and_to_the_environment(load):
    execution, _ = run(
        load,
        """broadcast chan a; clock x; int n;
        process P() { state A, B; init A; trans A -> B { guard x >= 3; sync a!; assign n = 1 }; }
        process Q(const int[0, 1] i) { state A, B; init A; trans A -> B { guard i == 1; sync a?; assign n = n + 1 }; }
        process W() { state A; init A; trans A -> A { sync a? }; } system W, Q, P;""",
        ["P", "Q"],
    )
    (step,) = execution.advance(3 * MS)
    assert edges([step]) == ["P.A>B", "Q(1).A>B"]
    assert (step.sent, execution.value("n")) == ("a", 2)


def test_binary_channels_between_executed_processes(load):
    execution, taken = run(
        load,
        """chan c; clock x; process P() { state A, B; init A; trans A -> B { sync c! }; }
        process Q() { state A, B; init A; trans A -> B { guard x >= 7; sync c? }; } system P, Q;""",
        ["P", "Q"],
    )
    assert (taken, execution.deadline) == ([], 7 * MS)
    assert edges(execution.advance(7 * MS)) == ["P.A>B", "Q.A>B"]


def test_a_template_stands_for_all_its_processes_and_a_process_for_itself(load):
    text = """process P(const int[0, 2] i) { state A, B; init A; trans A -> B { }; } X = P(0); system P, X;"""
    assert run(load, text, ["P"])[1] == ["P(0).A>B", "P(1).A>B", "P(2).A>B", "X.A>B"]
    assert run(load, text, ["P(1)", "X"])[1] == ["P(1).A>B", "X.A>B"]
    with pytest.raises(UsageError, match="'Q' is neither a process nor a template"):
        run(load, text, ["Q"])


# Windows of time ---------------------------------------------------------------------------------------------


def test_strict_bounds(load):
    execution, _ = run(
        load,
        """clock x; process P() { state A { x < 6 }, B; init A; trans
        A -> B { guard x > 5 }; } system P;""",
    )
    assert execution.deadline == 5 * MS + 1
    (step,) = execution.advance(6 * MS)
    assert (step.late_us, step.missed) == (999, True)


def test_a_window_that_never_opens_is_not_waited_for(load):
    execution, _ = run(
        load,
        """clock x; process P() { state A, B; init A; trans
        A -> B { guard x >= 5 && x < 5 }, A -> B { guard x >= 7 && x <= 7 }; } system P;""",
    )
    assert execution.deadline == 7 * MS


def test_a_window_that_is_over_when_its_data_guard_comes_true(load):
    execution, _ = run(
        load,
        """broadcast chan go; int level; clock x; process P() { state A, B; init A; trans
        A -> B { guard x <= 5 && level == 1 }; } process E() { state A; init A; trans A -> A { sync go!;
        assign level = 1 }; } system P, E;""",
        interface=["level"],
    )
    assert not execution.receive(Event("go", {"level": 1}), 5 * MS + 1).steps
    assert execution.deadline is None


def test_lateness_does_not_close_a_window(load):
    execution, _ = run(
        load,
        """clock x; process P() { state A, B; init A; trans
        A -> B { guard x >= 3 && x <= 5 }; } system P;""",
    )
    (step,) = execution.advance(9 * MS)
    assert (step.late_us, step.missed) == (6 * MS, True)


def test_a_target_whose_invariant_cannot_hold_disables_the_edge(load):
    execution, taken = run(
        load,
        """clock x; process P() { state A, B { x <= 3 }, C { x <= 2 }, D { x <= 1 }; init A;
        trans A -> B { guard x >= 4 }, A -> C { guard x >= 4; assign x = 3 }, A -> D { guard x >= 4; assign x = 1 };
        } system P;""",
    )
    assert taken == []
    assert edges(execution.run(9 * MS)) == ["P.A>D"]


def test_urgent_locations_wait_for_nothing(load):
    execution, taken = run(
        load,
        """clock x; process P() { state A, B, C; urgent A; init A; trans
        A -> B { guard x >= 1 }, A -> C { guard x >= 0 }; } system P;""",
    )
    assert (taken, execution.deadline) == ([], 0)
    assert edges(execution.advance(0)) == ["P.A>C"]


def test_an_edge_that_can_never_leave_an_urgent_location_is_not_waited_for(load):
    execution, _ = run(
        load,
        """clock x; process P() { state A, B; urgent A; init A; trans
        A -> B { guard x >= 1 }; } system P;""",
    )
    assert execution.deadline is None
    assert execution.advance(9 * MS) == ()


def test_an_edge_taken_again_is_due_anew(load):
    execution, _ = run(
        load,
        """clock x; int n; process P() { state A; init A; trans
        A -> A { guard x >= 1 && n < 3; assign n++ }; } system P;""",
    )
    assert [(step.due, step.late_us) for step in execution.advance(9 * MS)] == [
        (1 * MS, 8 * MS), (9 * MS, 0), (9 * MS, 0)
    ]  # fmt: skip


def test_shared_clocks_and_clocks_set_to_a_number(load):
    execution, _ = run(
        load,
        """clock t; int n; process P() { state A, B, C; init A; trans
        A -> B { guard t >= 10; assign t = 4 }, B -> C { guard t >= 10 }; }
        process Q() { state A, B; init A; trans A -> B { guard t >= 12 }; } system P, Q;""",
        ["P", "Q"],
    )
    assert [(step.at, *edges([step])) for step in execution.run(99 * MS)] == [
        (10 * MS, "P.A>B"), (16 * MS, "P.B>C"), (18 * MS, "Q.A>B")
    ]  # fmt: skip


def test_an_invariant_that_cannot_be_evaluated_is_told_when_its_location_is_entered(load):
    execution, _ = run(
        load,
        """const int T[2] = {5, 5}; int i = 1; clock x; process P() { state A, B { x <= T[i] };
        init A; trans A -> B { guard x >= 4; assign i = 2, x = 0 }; } system P;""",
    )
    assert execution.deadline == 4 * MS
    with pytest.raises(RangeError, match="Index 2 of 'T' is outside of 0 to 1"):
        execution.advance(4 * MS)


def test_the_unit_of_time_can_be_chosen(load):
    network = load("clock x; process P() { state A, B; init A; trans A -> B { guard x >= 2 }; } system P;")
    execution = Execution(network, ["P"], unit_us=1_000_000)
    execution.start(5)
    assert execution.deadline == 2_000_005


# Levels ------------------------------------------------------------------------------------------------------

LEVEL = """int[0, 3] evidence; broadcast chan changed; clock x; process P() { state A, B; init A; trans
    A -> B { guard evidence == 3 }, B -> A { guard evidence == 0 && x >= 5 }; }
    process E() { state A; init A; trans A -> A { select i : int[0, 3]; sync changed!; assign evidence = i }; }
    system P, E;"""


def test_levels_are_read_at_the_start(load):
    execution = Execution(load(LEVEL), ["P"], ["evidence"])
    assert edges(execution.start(0, {"evidence": 3})) == ["P.A>B"]


def test_a_write_with_a_time_is_reacted_to_at_once(load):
    execution, _ = run(load, LEVEL, interface=["evidence"])
    assert edges(execution.write({"evidence": 3}, 2 * MS)) == ["P.A>B"]
    assert execution.write({"evidence": 0}, 3 * MS) == ()
    assert execution.deadline == 5 * MS
    assert edges(execution.write({"evidence": 0}, 6 * MS)) == ["P.B>A"]


def test_a_write_without_a_time_waits_until_time_is_told(load):
    execution, _ = run(load, LEVEL, interface=["evidence"])
    execution.advance(2 * MS)
    assert execution.write({"evidence": 3}) == ()
    assert execution.deadline == 2 * MS
    assert edges(execution.advance(2 * MS)) == ["P.A>B"]


def test_an_event_that_nobody_takes_still_writes_and_may_enable_an_edge(load):
    execution, _ = run(load, LEVEL, interface=["evidence"])
    reaction = execution.receive(Event("changed", {"evidence": 3}), MS)
    assert not reaction.taken
    assert edges(reaction.steps) == ["P.A>B"]


# What never ends, and what gets stuck ------------------------------------------------------------------------


def test_a_livelock_is_told(load):
    with pytest.raises(ModelError, match="No end after 10000 steps at one instant: P never rest") as error:
        run(load, "process P() { state A, B; init A; trans A -> B { }, B -> A { }; } system P;")
    assert "model.xml" in error.value.where


def test_a_committed_location_without_a_way_on_is_told(load):
    with pytest.raises(ModelError, match="No edge leads on from the committed location 'A' of P"):
        run(
            load,
            """int a; process P() { state A, B; commit A; init A; trans A -> B { guard a == 1 }; } system P;""",
        )


def test_the_lateness_of_one_does_not_stop_another_in_a_committed_location(load):
    """Both are beyond their bounds: each goes its way to the end, and tells that it was late."""
    execution, _ = run(
        load,
        """clock x; clock y;
        process P() { state A { x <= 15 }, B, C; commit B; init A; trans A -> B { guard x >= 10 }, B -> C { }; }
        process Q() { state A { y <= 16 }, B; init A; trans A -> B { guard y >= 11 }; } system P, Q;""",
        ["P", "Q"],
    )
    steps = execution.advance(40 * MS)
    assert [(step.edges[0].process, step.edges[0].target, step.missed) for step in steps] == [
        ("P", "B", True),
        ("P", "C", True),
        ("Q", "B", True),
    ]
