"""What comes late, and what is stale: told by an alarm, counted, and never proof of anything; in virtual time."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import pytest

from end_effector_hal.codecs import Decoder, get_codec
from end_effector_hal.control import Controller, Status, network_of
from end_effector_hal.description import Description, EStop, examine_text, load, profile_path, used_channels
from end_effector_hal.signals import Frame, Kind, Value
from end_effector_hal.vocabulary import Evidence, display_name
from end_effector_lab.virtual import VirtualTool as LabTool
from tests.support.places import ROOT
from tests.support.virtual_tool import VirtualTool
from tests.unit.sensing.test_several_links import MS, TOOL

GRIPPED, STAND_BY = 3, 6
MIXED = ROOT / "tests" / "acceptance" / "kill_matrix" / "mixed_endings.yaml"
SHIPPED = sorted(profile_path().parent.parent.glob("*/end_effector.yaml"))

Change = Callable[[dict[str, Value], str], None]


def left_out(values: dict[str, Value], channel: str) -> None:
    del values[channel]


def marked_invalid(values: dict[str, Value], channel: str) -> None:
    values[channel] = None


def impossible(values: dict[str, Value], channel: str) -> None:
    values[channel] = 9_000_000


def frozen(values: dict[str, Value], channel: str) -> None:
    values[channel] = 600_000 if channel in ("cylinder", "supply") else -78_000


class Changed:
    """A decoder between the wire and the controller: one channel of each frame is changed."""

    def __init__(self, decoder: Decoder) -> None:
        self._decoder = decoder
        self.channel, self.change = "", marked_invalid

    def feed(self, data: bytes, at: int) -> list[Frame]:
        return [self._changed(frame) for frame in self._decoder.feed(data, at)]

    def _changed(self, frame: Frame) -> Frame:
        values = dict(frame.values)
        if self.channel:
            self.change(values, self.channel)
        return replace(frame, values=values)


def tools() -> list[Description]:
    shipped = [load(path) for path in (*SHIPPED, MIXED)]
    with_e_stop = shipped[0].model_copy(update={"e_stop": EStop(), "name": "with_e_stop"})
    return [*shipped, with_e_stop]


def when(number: int, channel: str, change: Change, seen: set[object]) -> list[pytest.MarkDecorator]:
    """In each run each channel left out once, and each change once; in CI each of the shipped tool."""
    what: object = channel if change is left_out else change
    if what not in seen:
        seen.add(what)
        return []
    return [pytest.mark.thinned if number == 0 or change is left_out else pytest.mark.nightly]


def cases() -> list[object]:
    found, seen = list[object](), set[object]()
    for number, tool in enumerate(tools()):
        kinds = get_codec(tool.link.codec).channels
        watched = {part.channel for part in (*tool.actuators.values(), tool.supply) if part.frozen_s}
        for channel in used_channels(tool):
            changes: list[Change] = [left_out, marked_invalid]
            changes += [impossible] if kinds[channel] is Kind.PRESSURE else []
            changes += [frozen] if channel in watched else []
            for change in changes:
                name = f"{tool.name}-{channel}-{change.__name__}"
                found.append(
                    pytest.param(tool, channel, change, id=name, marks=when(number, channel, change, seen))
                )
    return found


def named(status: Status, description: Description) -> set[str]:
    """Channels that the alarms say have no valid reading, by their names or by the actuator that is held."""
    found: set[str] = set()
    for alarm in status.alarm_texts:
        if alarm.startswith("No valid reading of ") and "while it holds a part" not in alarm:
            found |= set(re.findall(r"\w+", alarm.removeprefix("No valid reading of ").partition(":")[0]))
        for name, actuator in description.ordered:
            if alarm.startswith(f"No valid reading of {display_name(name)} while"):
                bits = (getattr(actuator, "extended_bit", None), getattr(actuator, "retracted_bit", None))
                found |= {channel for channel in (actuator.channel, *bits) if channel in status.stale}
    return found


@pytest.mark.parametrize(("description", "channel", "change"), cases())
def test_what_is_stale_is_an_alarm_and_the_other_way_round(
    description: Description, channel: str, change: Change
) -> None:
    tool = VirtualTool(description)
    changed = Changed(tool.decoder)
    tool.decoder = changed
    tool.run(1.0)
    for wanted in (STAND_BY, GRIPPED):
        if wanted == GRIPPED:
            assert tool.command("grip").accepted
            tool.run(4.0)
        assert [tool.status.ee, tool.status.stale] == [wanted, ()]
        changed.channel, changed.change = channel, change
        tool.run(2.3)
        assert (set(tool.status.stale), named(tool.status, description)) == ({channel}, {channel})
        changed.channel = ""
        tool.run(0.5)
        assert (tool.status.stale, named(tool.status, description)) == ((), set())


@pytest.mark.parametrize("description", tools(), ids=lambda tool: tool.name)
def test_a_silence_makes_every_channel_stale_and_tells_each(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    tool.link = False
    tool.run(0.2)
    assert set(tool.status.stale) == named(tool.status, description) == set(used_channels(description))


# A reading that turns stale in the instant of something else proves nothing from then on, whatever comes first.


STALE_US = 150 * MS


@pytest.fixture(scope="module")
def description() -> Description:
    found = examine_text(TOOL, "tool.yaml").description
    assert found is not None
    return found


class Tool:
    """Its controller, at rest with readings of both links; the one of the first link is the last one of it."""

    def __init__(self, description: Description) -> None:
        self.controller = Controller(description, network_of(description))
        self.controller.start({"A": False, "B": False}, 0)
        for number in range(1, 40):
            for channel in ("one", "two"):
                self.last = number * 20 * MS
                self.controller.frame(Frame(self.last, None, None, {channel: -100 - number}))
        assert self.status.evidence == (Evidence.GONE, Evidence.GONE)

    @property
    def status(self) -> Status:
        return self.controller.status()


INPUTS: dict[str, Callable[[Controller, int], list[Status]]] = {
    "a refusal": lambda controller, at: controller.refused(at),
    "a command": lambda controller, at: controller.command("cancel", at)[1],
    "an acknowledgement": lambda controller, at: controller.acknowledge(at),
}


@pytest.mark.parametrize("name", INPUTS)
def test_an_input_at_the_microsecond_in_which_a_reading_turns_stale(
    description: Description, name: str
) -> None:
    tool = Tool(description)
    stale_at = tool.last + STALE_US
    assert tool.controller.deadline == stale_at
    told = INPUTS[name](tool.controller, stale_at)
    assert told[-1].evidence[0] is Evidence.UNKNOWN
    again = INPUTS[name](tool.controller, stale_at)
    assert [status for status in again if name != "an acknowledgement"] == [], "it is published once"


def test_a_frame_that_came_before_and_is_taken_after(description: Description) -> None:
    tool = Tool(description)
    stale_at = tool.last + STALE_US
    for before in range(20 * MS, STALE_US, 20 * MS):
        tool.controller.frame(Frame(tool.last + before, None, None, {"two": -200 - before // MS}))
    frame = Frame(stale_at - 1 * MS, None, None, {"two": -100})
    told = tool.controller.frame(frame, stale_at + 2 * MS)
    assert told[-1].evidence == (Evidence.UNKNOWN, Evidence.GONE)
    assert told[-1].at == stale_at + 2 * MS


# A time-out that the machine takes late is taken late, counted, and told when it exceeds the reaction bound.


DUE = 6_000_000


@pytest.fixture
def tool() -> VirtualTool:
    """Shortly before the first time-out of the first step."""
    tool = VirtualTool(load(profile_path()), "never-confirms:bottom_vacuum")
    tool.run(1.0)
    tool.command("grip")
    tool.run(4.9)
    assert tool.status.deadline == DUE
    return tool


def confirm(tool: VirtualTool, stamp: int, at: int) -> list[Status]:
    """The third confirming frame comes at ``stamp`` and is taken at ``at``."""
    gripped = {**tool.bench.sample(tool.at), "bottom": -60_000}
    for earlier in (DUE - 40_000, DUE - 20_000):
        tool.controller.frame(Frame(earlier, None, None, gripped), earlier)
    return tool.controller.frame(Frame(stamp, None, None, gripped), at)


@pytest.mark.parametrize(("late_us", "missed"), [(0, 0), (50_000, 0), (50_001, 1)])
def test_a_late_time_out(tool: VirtualTool, late_us: int, missed: int) -> None:
    tool.controller.advance(DUE - 1)
    assert tool.status.outputs[0]
    statuses = tool.controller.advance(DUE + late_us)
    assert not statuses[-1].outputs[0]
    assert statuses[-1].at == DUE + late_us
    assert tool.status.worst_late_us == late_us
    assert tool.status.missed == missed
    assert tool.status.deadline == DUE + late_us + 1_000_000  # the reset lasts its second all the same


def test_what_came_before_a_time_out_is_before_it_however_late_it_is_taken(tool: VirtualTool) -> None:
    last = confirm(tool, DUE, DUE + 30_000)[-1]
    assert [step.attempts for step in last.steps] == [1, 1, 0]
    assert last.outputs == (True, True, False)
    assert last.at == DUE + 30_000
    assert tool.status.deadline == DUE + 30_000 + 5_000_000


def test_what_came_after_a_time_out_is_after_it(tool: VirtualTool) -> None:
    assert confirm(tool, DUE + 1, DUE + 30_000)[-1].outputs == (False, False, False)


# The time left that a status tells is that of the gripping, whatever else is due.


def test_an_arming_that_expires_is_not_the_time_left_of_a_grip() -> None:
    tool = load(profile_path())
    changer = tool.tool_changer
    armed = tool.model_copy(
        update={"tool_changer": changer.model_copy(update={"stand_bit": "none", "arm_s": 3.0})}
    )
    played = LabTool(armed, "never-confirms:bottom_vacuum")
    played.run(1.0)
    assert played.command("arm").accepted
    begun = played.at
    assert played.command("grip").accepted
    timeout_s = armed.actuators["bottom_vacuum"].timeout_s
    assert played.status.armed
    assert played.status.deadline == begun + round(timeout_s * 1e6)
