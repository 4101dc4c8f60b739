"""Table II: the integers that are logged never change."""

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.kinds.cylinder import CylinderState
from end_effector_hal.kinds.vacuum import VacuumState
from end_effector_hal.vocabulary import Command, EndEffectorState, display_name

PAPER = {
    EndEffectorState: ["OFF", "GRIPPING", "GRIP_ERROR", "GRIPPED", "RELEASING", "RELEASE_ERROR", "STAND_BY"],
    VacuumState: ["OFF", "PENDING ON", "ON"],
    CylinderState: ["RETRACTED", "PENDING EXTEND", "EXTENDED"],
}


@pytest.mark.parametrize(("table", "labels"), PAPER.items())
def test_values_and_labels_are_those_of_the_paper(table, labels):
    assert [(int(state), state.label) for state in table] == list(enumerate(labels))


def test_commands_are_those_of_the_paper():
    words = ["NONE", "LOCK", "UNLOCK", "GRIP", "RELEASE", "CANCEL", "QUIT"]
    assert [(int(command), command.label) for command in Command] == list(
        zip(range(-1, 6), words, strict=True)
    )


@pytest.mark.parametrize("name", ["STAND_BY", "STAND-BY", "stand by", " Stand_By "])
def test_a_state_is_found_by_its_name_in_any_spelling(name):
    assert EndEffectorState.named(name) is EndEffectorState.STAND_BY


def test_every_state_is_found_by_name_and_label():
    for table in (*PAPER, Command):
        for state in table:
            assert table.named(state.name) is table.named(state.label) is state


def test_an_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(UsageError, match=r"'OPEN' is no state of VacuumState. Known are OFF, PENDING_ON, ON"):
        VacuumState.named("OPEN")


def test_the_words_of_an_actuator_come_from_its_kind_then_from_its_name():
    assert recorded_kind("grabber", {"grabber": "cylinder"}).states is CylinderState
    assert recorded_kind("left_cylinder", {}).states is CylinderState
    assert recorded_kind("left_cylinder", {"left_cylinder": "vacuum"}).states is VacuumState
    assert recorded_kind("grabber", {}).states is VacuumState


def test_an_unknown_kind_in_a_recording_is_refused_with_the_known_ones():
    with pytest.raises(
        UsageError,
        match=r"there is no kind of actuator 'crane'.*There are: vacuum, cylinder, gripper, magnet",
    ):
        recorded_kind("grabber", {"grabber": "crane"})


def test_display_name():
    assert display_name("bottom_vacuum") == "Bottom vacuum"
