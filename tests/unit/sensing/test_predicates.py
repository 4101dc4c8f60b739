"""What the line arbiter is told of the sensors."""

from __future__ import annotations

from random import Random

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Controller, network_of
from end_effector_hal.description import Description, EStop, load, profile_path
from end_effector_hal.sensing import Predicates, predicates_fitted
from end_effector_hal.signals import Frame

MS, PERIOD = 1_000, 20_000
QUIET = {
    "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "cylinder_extended": False,
    "cylinder_retracted": True, "locked": True, "unlocked": False, "tool_present": True, "in_stand": True,
    "estop_ok": True,
}  # fmt: skip
ALL = {"locked": True, "nothing_gripped": True, "parked": True, "e_stop_closed": True}


class Feed:
    """Frames at 50 Hz; at the start all is proven."""

    def __init__(self, description: Description) -> None:
        self.predicates = Predicates(description, get_codec("ees1-ascii"))
        self.at, self.values = 1_000_000, dict(QUIET)
        assert self(40) == ALL

    def __call__(self, frames: int = 1, **values: int | bool | None) -> dict[str, bool]:
        self.values |= values  # type: ignore[arg-type]
        for index in range(frames):
            self.at += PERIOD
            values = {name: living(value, index) for name, value in self.values.items()}
            said = self.predicates.frame(Frame(self.at, None, None, values))
        return said


def living(value: int | bool | None, index: int) -> int | bool | None:
    """A pressure with a noise of one count, away from zero."""
    if value is None or isinstance(value, bool):
        return value
    return value + (index % 2 if value > 0 else -(index % 2))


@pytest.fixture
def feed() -> Feed:
    return Feed(load(profile_path()).model_copy(update={"e_stop": EStop()}))


def test_nothing_is_proven_before_the_first_frame() -> None:
    predicates = Predicates(load(profile_path()), get_codec("ees1-ascii"))
    assert predicates.advance(5) == {"locked": False, "nothing_gripped": False, "parked": False}


@pytest.mark.parametrize(
    ("values", "lost"),
    [
        ({"bottom": -5_000}, "nothing_gripped"),
        ({"in_stand": False}, "parked"),
        ({"in_stand": None}, "parked"),
        ({"top": -80_000}, "nothing_gripped"),
        ({"cylinder": 50_000}, "nothing_gripped"),
        ({"cylinder_extended": True}, "nothing_gripped"),
        ({"bottom": None}, "nothing_gripped"),
        ({"estop_ok": False}, "e_stop_closed"),
        ({"locked": False, "unlocked": True}, "locked"),
        ({"unlocked": True}, "locked"),
    ],
)
def test_each_sensor_counts(feed: Feed, values: dict[str, int | bool | None], lost: str) -> None:
    assert feed(50, **values) == ALL | {lost: False}
    assert feed(50, **QUIET) == ALL


def test_nothing_is_gripped_once_every_vacuum_was_under_5_kpa_for_half_a_second(feed: Feed) -> None:
    feed(bottom=-5_010)
    feed(bottom=-4_990)
    assert not feed(24)["nothing_gripped"]
    assert feed(1)["nothing_gripped"]


def test_an_absent_tool_is_as_good_as_one_in_its_stand(feed: Feed) -> None:
    assert feed(in_stand=False, tool_present=False) == ALL
    assert feed(tool_present=True) == ALL | {"parked": False}


def test_what_is_stale_proves_nothing(feed: Feed) -> None:
    assert feed.predicates.advance(feed.at + 149 * MS) == ALL
    assert feed.predicates.advance(feed.at + 150 * MS) == dict.fromkeys(ALL.keys() - {"e_stop_closed"}, False)


def test_after_a_silence_nothing_is_proven_by_what_was_so_before_it(feed: Feed) -> None:
    feed.at += 2_000 * MS
    assert feed() == ALL | {"locked": False, "nothing_gripped": False}
    assert feed(30) == ALL


def test_the_sensors_of_a_program_prove_the_same_as_sensors_of_its_own() -> None:
    """With silences and invalid values, and while the program also looks at its own time-outs."""
    description, random = load(profile_path()), Random(7)
    controller, own = Controller(description, network_of(description)), Predicates(description)
    shared, at, said = Predicates(description, senses=controller.senses), 1_000_000, list[dict[str, bool]]()
    controller.start({}, at)
    for number in range(1_000):
        at += (
            random.choice((PERIOD, PERIOD, PERIOD, 149_000, 150_000, 2_000_000))
            if number % 9 == 0
            else PERIOD
        )
        changed: dict[str, int | bool | None] = {}
        if number % 7 == 0:
            changed = {random.choice(list(QUIET)): random.choice((None, False, True, -80_000))}
        shown = {name: living(value, number) for name, value in (QUIET | changed).items()}
        frame = Frame(at, None, None, shown)
        said.append(own.frame(frame))
        controller.frame(frame)
        assert shared.said(shared.at) == said[-1]
        controller.advance(at + random.randrange(PERIOD))
    assert len({tuple(each.items()) for each in said}) > 4


def test_an_e_stop_that_was_not_read_is_not_said_to_be_open(feed: Feed) -> None:
    """It would be latched: a link that is silent, or not read yet, is no emergency stop."""
    silent_us = feed.at + 1_000 * MS
    assert "e_stop_closed" not in feed.predicates.advance(silent_us)
    assert "e_stop_closed" not in feed(8, estop_ok=None)
    assert feed(estop_ok=False)["e_stop_closed"] is False
    unread = Predicates(load(profile_path()).model_copy(update={"e_stop": EStop()}), get_codec("ees1-ascii"))
    assert "e_stop_closed" not in unread.advance(silent_us)


def test_what_the_codec_does_not_carry_is_not_fitted() -> None:
    description = load(profile_path()).model_copy(update={"e_stop": EStop()})
    nibble = get_codec("legacy-nibble")
    assert predicates_fitted(description, nibble) == {"locked", "nothing_gripped"}
    values = {"locked": True, "unlocked": False, "bottom": False, "top": False, "cylinder_extended": False}
    predicates = Predicates(description, nibble)
    for second in range(1, 4):
        said = predicates.frame(Frame(second * 1_000_000, None, None, values))
    assert said == {"locked": True, "nothing_gripped": True}
    changerless = description.model_copy(update={"tool_changer": None, "e_stop": None})
    assert predicates_fitted(changerless, nibble) == set()


def test_an_actuator_that_is_not_carried_does_not_stand_in_the_way() -> None:
    description = load(profile_path())
    top = description.actuators["top_vacuum"].model_copy(update={"channel": "elsewhere"})
    description = description.model_copy(update={"actuators": {**description.actuators, "top_vacuum": top}})
    predicates = Predicates(description, get_codec("ees1-ascii"))
    for frame in range(1, 30):
        said = predicates.frame(Frame(frame * PERIOD, None, None, QUIET))
    assert said["nothing_gripped"]


def test_a_frame_that_came_too_late_proves_nothing_and_objects(feed: Feed) -> None:
    """The machine stood still, and meanwhile the e-stop was open: it is latched."""
    late = dict(feed.values)
    now = feed.at + 10 * PERIOD
    assert feed.predicates.frame(Frame(feed.at + PERIOD, None, None, late), now) == {}
    late["estop_ok"] = False
    said = feed.predicates.frame(Frame(feed.at + PERIOD, None, None, late), now)
    assert said == {"e_stop_closed": False}
    assert feed.predicates.frame(Frame(now + PERIOD, None, None, late), now) == {}
