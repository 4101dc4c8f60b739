"""Section 4 of the contract: what a frame is worth, against the testbench's device and physics in virtual time."""

from __future__ import annotations

from itertools import groupby

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.sensing import SENT_INVALID, SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence
from tests.support.virtual_tool import VirtualTool

GRIPPED, STAND_BY = 3, 6
PERIOD = 20_000


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def ready(description: Description) -> VirtualTool:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.status.ee == STAND_BY
    assert tool.status.alarm_texts == ()
    return tool


def gripped(description: Description) -> VirtualTool:
    tool = ready(description)
    assert tool.command("grip").accepted
    tool.run(4.0)
    assert (tool.status.ee, tool.status.alarm_texts) == (GRIPPED, ())
    return tool


def choose(tool: VirtualTool, scenario: str, seconds: float) -> Status:
    tool.bench.choose(scenario, tool.at)
    tool.run(seconds)
    return tool.status


class Raw:
    """Frames into the detectors, value by value; pressures have the noise of a living sensor."""

    def __init__(self, description: Description, codec: str = "ees1-ascii") -> None:
        self.senses = SensorSet(description, get_codec(codec))
        self.at, self.seq, self.uptime_ms = 1_000_000, 100, 50_000
        self.values: dict[str, int | bool | None] = {
            "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "locked": True, "unlocked": False,
            "cylinder_extended": False, "cylinder_retracted": True, "in_stand": False, "tool_present": True,
        }  # fmt: skip

    def __call__(self, frames: int = 1, *, noise: int = 1, **values: int | bool | None) -> None:
        self.values |= values
        for _ in range(frames):
            self.at, self.seq, self.uptime_ms = self.at + PERIOD, self.seq + 1, self.uptime_ms + 20
            shown = {
                name: value if value is None or isinstance(value, bool) else value - self.seq % 2 * noise
                for name, value in self.values.items()
            }
            self.senses.frame(Frame(self.at, self.seq, self.uptime_ms, shown))

    @property
    def notices(self) -> tuple[str, ...]:
        return tuple(map(str, self.senses.notices(self.at, held=False)))


# Link: stale after 150 ms, down after 1 s


def test_silence_is_told_while_it_is_short_and_when_the_link_is_down(description: Description) -> None:
    tool = ready(description)
    tool.link = False
    tool.run(0.14)
    assert tool.status.alarm_texts == ()
    tool.run(0.02)
    assert tool.status.evidence == (0, 0, 0)
    assert tool.status.alarm_texts == (
        "No valid reading of bottom, cylinder, cylinder_extended, cylinder_retracted, top, locked, unlocked, "
        "in_stand, tool_present, supply.",
    )
    tool.run(1.0)
    assert tool.status.alarm_texts == ("The sensor link /dev/verdin-uart1 is down.",)
    tool.link = True
    tool.run(0.5)
    assert (tool.status.alarm_texts, tool.status.evidence) == ((), (1, 1, 1))


def test_one_channel_without_a_value_is_named(description: Description) -> None:
    status = choose(ready(description), "invalid:top_vacuum", 0.2)
    assert status.alarm_texts == (f"No valid reading of top: {SENT_INVALID}.",)
    assert status.evidence[2] == Evidence.UNKNOWN


# Device reboot


def test_after_a_reboot_nothing_is_known_until_it_is_fresh(description: Description) -> None:
    raw = Raw(description)
    raw(20, bottom=-60_000)
    assert raw.senses.now.evidence[0] is Evidence.CONFIRMED
    raw.seq = raw.uptime_ms = -1  # without any silence, and with readings that are still fresh
    raw(1)
    assert raw.senses.now.evidence == (Evidence.UNKNOWN, Evidence.PARTIAL, Evidence.GONE)
    raw(4)
    assert raw.senses.now.evidence[0] is Evidence.UNKNOWN
    raw(1)
    assert (
        raw.senses.now.evidence[0] is Evidence.CONFIRMED
    )  # 100 ms of the new life, in which the lock is proven
    assert raw.notices == ("The device that reads the sensors restarted; earlier readings were discarded.",)


@pytest.mark.parametrize("lost_after_reboot", [0, 7])
def test_what_was_read_before_a_reboot_counts_no_more(
    description: Description, lost_after_reboot: int
) -> None:
    raw = Raw(description)
    raw(20, top=-60_000)
    raw.seq = raw.uptime_ms = lost_after_reboot
    raw(1, top=None)  # invalid at first: the reading of before is 20 ms old, and nothing
    assert raw.senses.now.readings.get("top", raw.at) is None
    assert raw.senses.now.evidence[2] is Evidence.UNKNOWN


@pytest.mark.parametrize("held", [False, True])
def test_two_senders_on_one_link_are_one_alarm_and_prove_nothing(
    description: Description, held: bool
) -> None:
    """Each frame was a reboot with a number of its own: up to 100 alarms in a second."""
    tool = (gripped if held else ready)(description)
    tool.statuses.clear()
    for n in range(150):
        tool.run(0.02)
        shown = {"bottom": -70_000, "cylinder": 500_000, "top": -70_000, "supply": 600_000, "locked": True}
        other = Frame(tool.at, 9000 + n, 500_000 + 20 * n, {**shown, "unlocked": False})
        tool._told(tool.controller.frame(other))
    assert [alarms for alarms in tool.status.alarm_texts if alarms.startswith("Two senders on one link")]
    assert tool.status.evidence == (0, 0, 0)
    assert (tool.status.held, tool.status.lift_allowed) == (held, False)
    changes = [alarms for alarms, _ in groupby(status.alarm_texts for status in tool.statuses)]
    assert len(changes) <= 12, changes
    if not held:
        assert len(tool.status.alarm_texts) == 1
    tool.run(12)
    assert all(alarm.startswith("Over: ") for alarm in tool.status.alarm_texts)
    assert tool.status.evidence == ((3, 3, 3) if held else (1, 1, 1))


def test_a_reboot_while_gripped_holds_and_is_told(description: Description) -> None:
    tool = gripped(description)
    edges = tool.edges.copy()
    status = choose(tool, "reboot-after:0", 0.2)
    assert (status.ee, status.evidence, status.lift_allowed) == (GRIPPED, (0, 0, 0), False)
    tool.run(0.4)
    assert (tool.status.ee, tool.status.evidence) == (GRIPPED, (3, 3, 3))
    assert (
        "The device that reads the sensors restarted; earlier readings were discarded."
        in tool.status.alarm_texts
    )
    tool.run(11.0)
    assert not any("restarted" in alarm for alarm in tool.status.alarm_texts)
    assert tool.edges == edges


def test_a_number_that_wraps_around_is_no_reboot(description: Description) -> None:
    raw = Raw(description)
    raw.seq, raw.uptime_ms = 65_530, (1 << 32) - 100
    raw.values |= {"bottom": -60_000}
    for _ in range(20):
        raw.seq, raw.uptime_ms = raw.seq % (1 << 16), raw.uptime_ms % (1 << 32)
        raw()
    assert raw.notices == ()
    assert raw.senses.now.evidence[0] is Evidence.CONFIRMED


# Values that cannot be


@pytest.mark.parametrize(
    ("channel", "possible", "impossible", "what"),
    [
        ("bottom", 50_000, 51_000, "shows 51 kPa, which a vacuum circuit cannot have (-110 to 50 kPa)"),
        ("top", -109_000, -111_000, "shows -111 kPa, which a vacuum circuit cannot have"),
        ("cylinder", -9_000, -11_000, "shows -11 kPa, which compressed air cannot have (-10 to 2000 kPa)"),
        ("supply", 1_999_000, 2_001_000, "shows 2001 kPa, which compressed air cannot have"),
    ],
)
def test_what_cannot_be_is_invalid_and_said(
    description: Description, channel: str, possible: int, impossible: int, what: str
) -> None:
    raw = Raw(description)
    raw(20, **{channel: possible})
    assert raw.notices == ()
    raw(1, **{channel: impossible})
    assert raw.senses.now.readings.get(channel, raw.at) is None
    doubt, lacking = raw.notices
    assert doubt.startswith(f"The channel {channel} {what}")
    assert lacking == f"No valid reading of {channel}."
    raw(3, **{channel: possible})
    assert raw.notices == ()


def test_a_doubt_is_told_in_the_words_of_its_beginning(description: Description) -> None:
    raw = Raw(description)
    raw(20)
    said = set()
    for kpa in range(300, 400):
        raw(1, bottom=kpa * 1000)
        said.add(raw.notices[0])
    assert len(said) == 1


def test_a_vacuum_and_a_cylinder_that_are_exchanged_are_found(description: Description) -> None:
    tool = gripped(description)
    edges = tool.edges.copy()
    status = choose(tool, "swapped:bottom_vacuum", 0.5)
    assert (status.ee, status.held, status.lift_allowed) == (GRIPPED, True, False)
    assert [alarm.split()[2] for alarm in status.alarm_texts if "exchanged" in alarm] == [
        "bottom",
        "cylinder",
    ]
    assert tool.edges == edges


# A frozen sensor


def test_a_sensor_that_does_not_move_by_a_count_is_frozen(description: Description) -> None:
    raw = Raw(description)
    raw(21, bottom=-60_000)
    raw(100, noise=0)
    assert raw.senses.now.evidence[0] is Evidence.CONFIRMED  # the first of them was a change: 1.98 s
    raw(1, noise=0)
    assert raw.senses.now.evidence == (Evidence.UNKNOWN,) * 3
    assert raw.notices[0].startswith(
        "The channel bottom has not moved by a single count: its sensor is frozen"
    )
    assert not raw.senses.now.supply.ok
    raw(3, noise=1)
    assert raw.senses.now.evidence[0] is Evidence.CONFIRMED
    assert raw.notices == ()


def test_a_frozen_sensor_while_gripped_is_unknown_and_nothing_is_let_go(description: Description) -> None:
    tool = gripped(description)
    edges = tool.edges.copy()
    status = choose(tool, "frozen-after:top_vacuum:0", 2.1)
    assert (status.ee, status.evidence) == (GRIPPED, (3, 3, 0))
    assert not status.lift_allowed
    assert any("The channel top has not moved" in alarm for alarm in status.alarm_texts)
    assert tool.edges == edges


def test_a_frozen_sensor_refuses_a_grip_with_a_sentence(description: Description) -> None:
    tool = ready(description)
    choose(tool, "frozen-after:bottom_vacuum:0", 2.2)
    answer = tool.command("grip")
    assert not answer.accepted
    assert answer.reason == (
        "IL-07: Bottom vacuum is not proven to be gone: bottom has no valid reading; gone means less than 10 kPa "
        "below ambient. Check its sensor."
    )


def test_frozen_is_off_unless_declared_and_where_the_codec_counts_coarsely(description: Description) -> None:
    actuators = {
        name: actuator.model_copy(update={"frozen_s": None})
        for name, actuator in description.actuators.items()
    }
    quiet = description.model_copy(update={"actuators": actuators})
    for tool, codec in ((quiet, "ees1-ascii"), (description, "modbus-rtu-transmitters")):
        raw = Raw(tool, codec)
        raw(300, noise=0, bottom=-60_000)
        assert raw.senses.now.evidence[0] is Evidence.CONFIRMED


def test_a_silence_is_no_standing_still(description: Description) -> None:
    raw = Raw(description)
    raw(60, noise=0, bottom=-60_000)
    raw.at += 1_500_000
    raw(60, noise=0)
    assert raw.senses.now.evidence[0] is Evidence.CONFIRMED


def test_booleans_are_never_frozen(description: Description) -> None:
    senses = SensorSet(description, get_codec("legacy-nibble"))
    values = {"bottom": True, "top": True, "cylinder_extended": True, "locked": True, "unlocked": False}
    for second in range(1, 30):
        senses.frame(Frame(second * 1_000_000, None, None, values))
    assert senses.now.evidence == (Evidence.CONFIRMED,) * 3
    assert senses.notices(29_000_000, held=True) == ()
