"""Table II's integers, which never change; alarms, which have an identity and their texts in one table."""

from __future__ import annotations

import itertools
from dataclasses import replace
from string import Formatter

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.kinds.cylinder import CylinderState
from end_effector_hal.kinds.vacuum import VacuumState
from end_effector_hal.vocabulary import (
    ALARMS,
    LEAK,
    Alarm,
    Command,
    EndEffectorState,
    alarm_changes,
    display_name,
    distinct,
    received_alarms,
    with_since,
)

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


# Alarms have an identity; their texts stand in one table.


LEAKS = Alarm(LEAK, "top_vacuum", {"falls": 3.7, "kpa": 65.5, "lost_kpa": 50.0, "left_s": 4.2}, 7)
LEAKED = Alarm(LEAK, "top_vacuum", {"kpa": 66.0}, 7, over=True)
DOWN = Alarm("link.down", "cups", {"sensors": "sensor link cups is down"})


@pytest.mark.parametrize("id_", ALARMS)
def test_each_text_is_a_sentence_that_its_values_complete(id_: str) -> None:
    kind = ALARMS[id_]
    assert kind.severity in ("error", "warning")
    for template in (*kind.texts, kind.over):
        fields = [(name, spec) for _, name, spec, _ in Formatter().parse(template) if name]
        values = {name: 1.5 if spec else "x" for name, spec in fields if name not in ("who", "about")}
        text = Alarm(id_, "top_vacuum", values, over=template == kind.over).text
        assert "{" not in text
        assert text


def test_the_sentences_of_a_leak() -> None:
    assert str(LEAKS) == (
        "Leak: Top vacuum falls by 3.7 kPa/s from 65.5 kPa and would be lost (under 50 kPa) in 4 s."
    )
    assert str(LEAKED) == "Over: Top vacuum leaked for a while; it is at 66 kPa now."
    assert (LEAKS.key, LEAKS.severity, LEAKED.name) == (LEAKED.key, "warning", "over:grip.leak:top_vacuum")


def test_an_alarm_begins_is_over_and_ends_by_its_identity() -> None:
    """Two alarms with the same words are told apart, and one whose numbers change is the same."""
    other = replace(LEAKED, about="bottom_vacuum")
    rounds = [(), (DOWN, LEAKS), (DOWN, replace(LEAKS, since=9)), (LEAKED, other), ()]
    told = [list(alarm_changes(before, now)) for before, now in itertools.pairwise(rounds)]
    assert told == [
        [(DOWN, "begun"), (LEAKS, "begun")],
        [],
        [(DOWN, "ended"), (LEAKED, "over"), (other, "over")],
        [(LEAKED, "ended"), (other, "ended")],
    ]


def test_two_programs_report_an_alarm_once_with_the_time_of_its_beginning() -> None:
    first, again = with_since((DOWN,), (), 5)[0], with_since((DOWN,), (), 8)[0]
    assert distinct((first, LEAKS, again)) == (first, LEAKS)
    assert distinct((LEAKED, first, LEAKS)) == (LEAKS, first)
    assert with_since((DOWN, LEAKS), (first,), 9) == (first, LEAKS)


def test_what_comes_in_a_message_is_bounded_and_keeps_its_identity_and_sentence() -> None:
    sent = (LEAKS, LEAKED, DOWN)
    found = received_alarms([str(each) for each in sent], [each.name for each in sent])
    assert [(each.key, each.over, str(each)) for each in found] == [
        (each.key, each.over, str(each)) for each in sent
    ]
    strange = received_alarms(["a\nb" * 1_000, "No id."] * 500, ["no.such:x"])
    assert len(strange) == 256
    assert {each.id for each in strange} == {"unknown"}
    assert all(
        len(each.about) <= 200 and len(each.text) <= 500 and each.text.isprintable() for each in strange
    )


@pytest.mark.parametrize("alarm", [Alarm("no.such", "x"), Alarm(LEAK, "x", {"kpa": "much"})])
def test_what_no_text_fits_is_named_by_its_identity(alarm: Alarm) -> None:
    assert str(alarm) == f"{alarm.id} x"
