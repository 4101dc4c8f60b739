"""Alarms have an identity; their texts stand in one table."""

from __future__ import annotations

import itertools
from dataclasses import replace
from string import Formatter

import pytest

from end_effector_hal.vocabulary import (
    ALARMS,
    LEAK,
    Alarm,
    alarm_changes,
    distinct,
    received_alarms,
    with_since,
)

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
