"""A channel without a valid reading is ``stale`` and is told by an alarm: both, or neither; in virtual time."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import pytest

from end_effector_hal.codecs import Decoder, get_codec
from end_effector_hal.control import Status
from end_effector_hal.description import Description, EStop, load, profile_path, used_channels
from end_effector_hal.signals import Frame, Kind, Value
from end_effector_hal.vocabulary import display_name
from tests.support.places import ROOT
from tests.support.virtual_tool import VirtualTool

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
