"""The events of the sensors: who only hears these knows what the sensors prove."""

from __future__ import annotations

import random

import pytest

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame
from timed_automata import Event

DESCRIPTION = load(profile_path())
PERIOD_US = 20_000
PRESSURES = (0, -30_000, -78_000, None)


def proven(senses: SensorSet) -> dict[str, int]:
    evidence = {f"evidence[{index}]": int(level) for index, level in enumerate(senses.now.evidence)}
    return evidence | {"tool": int(senses.now.tool)}


@pytest.mark.parametrize("seed", range(10))
def test_the_events_lead_from_what_was_proven_to_what_is(seed: int) -> None:
    """Also where one frame makes two changes, because its device has restarted."""
    chooser, senses = random.Random(seed), SensorSet(DESCRIPTION, carrier_of(DESCRIPTION))
    heard, at, number, restarts = proven(senses), 0, 0, 0
    held: dict[str, int | bool | None] = {}

    def hear(events: list[Event]) -> None:
        for event in events:
            heard.update(event.writes)
        assert heard == proven(senses)

    for _ in range(1_500):
        before, at = at, at + (PERIOD_US if chooser.random() < 0.98 else chooser.choice((200_000, 1_500_000)))
        while (due := senses.deadline(before)) is not None and due < at:
            hear(senses.advance(due))
            before = due
        if chooser.random() < 0.05 or not held:
            held = {name: chooser.choice(PRESSURES) for name in ("bottom", "top")}
            held |= {"cylinder": chooser.choice((0, 550_000)), "supply": 600_000}
            locked = chooser.random() < 0.5
            held |= {"locked": locked, "unlocked": not locked, "tool_present": True, "in_stand": False}
            out = chooser.random() < 0.5
            held |= {"cylinder_extended": out, "cylinder_retracted": not out, "estop_ok": True}
        restarts_now = chooser.random() < 0.02
        number, restarts = (0 if restarts_now else number + 1), restarts + restarts_now
        noise = chooser.randrange(200)
        values = {
            name: value + noise if isinstance(value, int) and not isinstance(value, bool) else value
            for name, value in held.items()
        }
        hear(senses.frame(Frame(at, number, number * 20, values)))
    assert restarts > 10
