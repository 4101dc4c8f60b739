"""What an event would lead to is worked out ahead: it is what happens later, and it is not computed again."""

from random import Random

import pytest

from tests.unit.timed_automata.explore.models import load
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


def lamp():
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


def look_everywhere(execution):
    return [found for event in (Event("press"), None) if (found := execution.foresee(event))]


def test_nothing_is_taken_otherwise():
    looked = play(lamp(), look_everywhere)
    assert looked == play(lamp(), lambda _: None)
    assert len(looked) == 7


def test_nothing_is_computed_when_it_happens(monkeypatch):
    execution = lamp()
    (found,) = look_everywhere(execution)
    assert found.after.location("Lamp") == "Low"

    def computed(*_):
        raise AssertionError("it is known already")

    for name in ("transitions", "received", "fire", "invariant"):
        monkeypatch.setattr(Semantics, name, computed)
    assert [step.edges[0].target for step in execution.receive(Event("press"), 1_000).steps] == [
        "Chosen",
        "Low",
    ]


def test_what_time_brings_is_computed_ahead(monkeypatch):
    execution = lamp()
    execution.receive(Event("press"), 1_000)
    assert execution.foresee(None).after.location("Lamp") == "Off"
    monkeypatch.setattr(Semantics, "transitions", None)
    assert [step.edges[0].target for step in execution.advance(6_000)] == ["Off"]


def test_the_state_stays():
    execution = lamp()
    before = execution.snapshot()
    look_everywhere(execution)
    assert execution.snapshot() == before


def test_an_event_that_no_edge_receives_leads_to_nothing():
    execution = lamp()
    for at in (1_000, 7_000, 14_000):
        execution.advance(at)
        execution.receive(Event("press"), at)
    assert execution.location("Lamp") == "Broken"
    assert not look_everywhere(execution)


def test_nothing_is_foreseen_once_something_is_due():
    execution = lamp()
    execution.receive(Event("press"), 1_000)
    assert execution.foresee(Event("press")).until == 6_000
    execution.receive(Event("press"), 6_000)  # at the instant of the time-out, which is still due
    assert execution.foresee(Event("press")) is None
    assert [step.due for step in execution.foresee(None).steps] == [6_000]


DOOR = """
    clock x, y; broadcast chan knock, open, late; int n;
    process Door() {
        state Shut, Asked, Wide { y <= 4 }, Slow; commit Asked; init Shut;
        trans Shut -> Asked { sync knock?; assign y = 0; },
              Asked -> Wide { guard x < 10; sync open!; },
              Asked -> Slow { guard x >= 10; sync late!; },
              Wide -> Shut { guard y >= 4; assign n = n + 1; };
    }
    process Visitor() { state A; init A; trans A -> A { sync knock!; }; }
    system Door, Visitor;
"""


def test_it_holds_until_a_clock_decides_otherwise():
    execution = Execution(load(DOOR), ["Door"])
    execution.start(0)
    found = execution.foresee(Event("knock"))
    assert [step.sent for step in found.steps] == [None, "open"]
    assert found.until == 10_000  # the clock that the event resets does not matter
    execution.advance(9_999)
    assert execution.foresee(Event("knock")).until == 10_000
    execution.advance(10_000)
    assert [step.sent for step in execution.foresee(Event("knock")).steps] == [None, "late"]


def steps_of(steps):
    return [(step.edges, step.changes, step.sent, step.received) for step in steps]


@pytest.mark.parametrize(("text", "process", "channel"), [(LAMP, "Lamp", "press"), (DOOR, "Door", "knock")])
def test_what_was_foreseen_happens(text, process, channel):
    network, random, seen = load(text), Random(7), 0
    for _ in range(200):
        execution, at = Execution(network, [process]), 0
        execution.start(0)
        for _ in range(6):
            found = execution.foresee(Event(channel))
            at += random.choice((1, 500, 1_000, 3_999, 4_000, 5_000, 6_001))
            early = execution.deadline is None or at < execution.deadline
            steps = execution.receive(Event(channel), at).steps
            if found is not None and at < found.until:
                assert early
                assert steps_of(steps) == steps_of(found.steps)
                seen += 1
            execution.advance(at)
    assert seen > 200


def test_a_fault_that_is_only_possible_is_none():
    text = """int[0,1] n; int list[2]; broadcast chan go, wrong;
        process P() { state A, B; commit B; init A;
            trans A -> B { sync go?; }, B -> A { guard list[n + 2] == 0; }, A -> A { sync wrong?; assign n = n + 2; }; }
        process E() { state A; init A; trans A -> A { sync go!; }, A -> A { sync wrong!; }; }
        system P, E;"""
    execution = Execution(load(text), ["P"])
    execution.start(0)
    assert execution.foresee(Event("go")) is execution.foresee(Event("wrong")) is None
    assert execution.location("P") == "A"
    with pytest.raises(ValueError, match="Index"):
        execution.receive(Event("go"), 1)
