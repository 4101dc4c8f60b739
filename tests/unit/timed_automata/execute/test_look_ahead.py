"""What is worked out beforehand: nothing that happens later is otherwise, and it is not computed again."""

import pytest

from timed_automata import Event, Execution
from timed_automata.network import Semantics

LAMP = """
    clock x; int presses, level; broadcast chan press, news; chan never;
    process Lamp() {
        state Off, Chosen, Low { x <= 5 }, Broken; commit Chosen; init Off;
        trans Off -> Chosen { sync press?; assign presses = presses + 1, x = 0; },
              Chosen -> Low { guard presses < 3; sync news!; assign level = 1; },
              Chosen -> Broken { guard presses >= 3; assign level = 0; },
              Low -> Off { guard x >= 5; assign level = 0; },
              Low -> Chosen { sync press?; assign presses = presses + 1; };
    }
    process User() { state A; init A; trans A -> A { sync press!; }; }
    system Lamp, User;
"""


def lamp(load):
    execution = Execution(load(LAMP), ["Lamp"])
    execution.start(0)
    return execution


def play(execution, look):
    steps = []
    for at in (1_000, 3_000, 20_000, 21_000):
        look(execution)
        steps += execution.advance(at - 1)
        look(execution)
        steps += execution.receive(Event("press"), at).steps
    return steps


def test_nothing_is_taken_otherwise(load):
    looked = play(lamp(load), lambda execution: list(execution.look_ahead([Event("press")])))
    assert looked == play(lamp(load), lambda _: None)
    assert len(looked) == 7


def test_nothing_is_computed_when_it_happens(load, monkeypatch):
    execution = lamp(load)
    states = list(execution.look_ahead([Event("press")]))
    assert len(states) == len(set(states)) == 2  # Chosen, and what follows it at once

    def computed(*_):
        raise AssertionError("it is known already")

    for name in ("transitions", "received", "fire", "invariant"):
        monkeypatch.setattr(Semantics, name, computed)
    assert [step.edges[0].target for step in execution.receive(Event("press"), 1_000).steps] == [
        "Chosen",
        "Low",
    ]


def test_the_state_stays(load):
    execution = lamp(load)
    before = execution.snapshot()
    list(execution.look_ahead([Event("press")]))
    assert execution.snapshot() == before


def test_a_fault_that_is_only_possible_is_none(load):
    text = """int[0,1] n; int list[2]; broadcast chan go, wrong;
        process P() { state A, B; commit B; init A;
            trans A -> B { sync go?; }, B -> A { guard list[n + 2] == 0; }, A -> A { sync wrong?; assign n = n + 2; }; }
        process E() { state A; init A; trans A -> A { sync go!; }, A -> A { sync wrong!; }; }
        system P, E;"""
    execution = Execution(load(text), ["P"])
    execution.start(0)
    list(execution.look_ahead([Event("go"), Event("wrong")]))
    assert execution.location("P") == "A"
    with pytest.raises(ValueError, match="Index"):
        execution.receive(Event("go"), 1)
