"""A run of the model leaves the recording that a real run with the same states leaves."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from random import Random

import pytest

from end_effector_hal.description import SHIPPED_AUTOMATA
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import GripDecision, read_story
from end_effector_hal.verification import has_states, states_of
from timed_automata import Change, State, Trace, TraceStep, load_network, make_network, read_document
from timed_automata.simulate import parse_choices, simulate

NAMES = ("bottom_vacuum", "cylinder", "top_vacuum")


@pytest.fixture(scope="module")
def shipped():
    return load_network(SHIPPED_AUTOMATA)


def played(network, choices):
    return simulate(network, Random(0), parse_choices(network, choices)).trace


def test_a_row_per_change_in_the_integers_of_table_ii(shipped):
    trace = played(
        shipped, "world == IN_TIME; adopt @ 20; grip @ 1000; confirmed[0] + 350; confirmed[1] + 400.5"
    )
    log = states_of(trace, NAMES)
    assert log.actuators == NAMES
    assert [(row.time_s, *map(int, row.states)) for row in log.rows] == [
        (0.0, 0, -1, 0, 0, 0),
        (0.02, 6, -1, 0, 0, 0),
        (1.0, 1, 2, 0, 0, 0),
        (1.0, 1, 2, 1, 0, 0),
        (1.35, 1, 2, 2, 0, 0),
        (1.35, 1, 2, 2, 1, 0),
        (1.7505, 1, 2, 2, 2, 0),
        (1.7505, 1, 2, 2, 2, 1),
    ]


def test_it_ends_with_the_run(shipped):
    run = simulate(shipped, Random(0), parse_choices(shipped, "world == IN_TIME; adopt"), steps=0).trace
    log = states_of(dataclasses.replace(run, end=Fraction(2500)))
    assert [row.time_s for row in log.rows] == [0.0, 2.5]
    assert log.actuators == ("actuator_0", "actuator_1", "actuator_2")


def test_it_tells_the_story_of_a_recording(shipped):
    log = states_of(
        played(
            shipped,
            "world == NEVER && culprit == 0; adopt; grip @ 1000; Gripper.Reset; Gripper.Activate; Gripper.Reset;"
            "Gripper.Activate; ee == GRIP_ERROR; ee == STAND_BY",
        ),
        NAMES,
    )
    (grip,) = read_story(log).grips
    assert (grip.decision, grip.culprit, len(grip.timeouts)) == (GripDecision.ABORTED, "bottom_vacuum", 3)
    assert (grip.start_s, grip.decided_s) == (1.0, 18.0)


def test_values_beyond_table_ii_are_refused(shipped):
    values = list(shipped.initial.values)
    values[shipped.offset("ee")] = 9
    state = State(shipped.initial.locations, tuple(values))
    trace = Trace(shipped, (TraceStep(Fraction(1), None, (), state, (Change("ee", 0, 9),)),), Fraction(1), "")
    with pytest.raises(UsageError, match="Not in Table II: 9"):
        states_of(trace)
    with pytest.raises(UsageError, match="2 names for the 3 actuators"):
        states_of(trace, ("a", "b"))


def test_other_models_have_no_such_states(shipped):
    assert has_states(shipped)
    text = "<nta><declaration>int ee, command;</declaration>{}<system>system P;</system></nta>".format(
        '<template><name>P</name><location id="a"/><init ref="a"/></template>'
    )
    assert not has_states(make_network(read_document(text.encode(), "m.xml")))
