"""Collects the values of every channel and the evidence that follows from them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Self

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from end_effector_hal.codecs import carrier_of, codec_of, sources_of
from end_effector_hal.description import Description, network_address
from end_effector_hal.errors import LinkError
from end_effector_hal.kinds import kind_of
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import GAUGE_PRESSURE, Frame, Kind, Measure, Value
from end_effector_hal.wires import now_us
from end_effector_hal.wires.sensors import SensorReader

from ._hearing import link_title, why_no_frame

LOST_US = 1_000_000
"""Time without a frame after which the inputs count as lost, µs."""
KEPT = 64
"""Number of frames over which a rate is computed."""
SHOWN = 24
"""Number of the newest bytes that are shown."""
SAMPLE = 65_536
"""Number of bytes that are kept to recognise another codec."""


@dataclass
class HeardLink:
    """The data of one link: its newest bytes, its first bytes, and the error counts from before the first frame."""

    title: str
    codec: str
    newest: bytes = b""
    sample: bytearray = field(default_factory=bytearray)
    before: dict[str, int] | None = None


class ChannelView:
    """Collects the values of all sources of a tool and the evidence that follows from them; the sources are read
    within its context.

    Args:
        begun: the time now, µs.
    """

    def __init__(self, tool: Description, begun: int) -> None:
        self.tool, self.begun = tool, begun
        carrier = carrier_of(tool)
        self.channels = carrier.channels
        self.sensors = SensorSet(tool, carrier)
        self.links = {
            name: HeardLink(link_title(tool, name), codec_of(tool, name).name if link.frame is None else "")
            for name, link in tool.links.items()
        }
        only = next(iter(tool.links), None)
        self._link_of = {
            name: only if source.link is None and len(tool.links) == 1 else source.link
            for source in sources_of(carrier)
            for name in source.channels
            if not (name in tool.channels and tool.channels[name].on_board)
        }
        self.values: dict[str, Value] = {}
        self.came_at: dict[str, int] = {}
        self.arrivals: dict[str, deque[int]] = {name: deque(maxlen=KEPT) for name in self.channels}
        self.due: int | None = None
        self._came: SimpleQueue[Frame | tuple[str, bytes]] = SimpleQueue()
        self._reader = SensorReader(
            tool, self._came.put, on_bytes=lambda name, data: self._came.put((name, data))
        )

    def __enter__(self) -> Self:
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    def hear(self, longest_s: float) -> None:
        """Process what arrives within a time; raise LinkError if a source could not be opened, but not if one was
        lost.
        """
        with suppress(Empty):
            self._take(self._came.get(timeout=longest_s))
            while True:
                self._take(self._came.get_nowait())
        now = now_us()
        if self.due is not None and self.due <= now:
            self.sensors.advance(now)
        self.due = self.sensors.deadline(now)
        health = self._reader.health
        errors = [link.error for link in health.links.values()]
        if (
            inputs := health.inputs
        ):  # some of them may come while others, which the line arbiter reads, do not
            heard = inputs.last_frame is not None and now - inputs.last_frame < LOST_US
            errors.append("" if heard else inputs.error)
        if all(errors) and not any(each.opened for each in (*health.links.values(), health.inputs) if each):
            raise LinkError(errors[0])

    def need_frames(self) -> None:
        """Raise LinkError with the remedy if no frame has arrived over some link."""
        for name, link in self._reader.health.links.items():
            if not link.frames:
                heard = self.links[name]
                if link.error:
                    raise LinkError(link.error)
                if link.faults:
                    raise LinkError(" ".join(link.faults), where=heard.title)
                network = network_address(self.tool.links[name].port) is not None
                what, todo = why_no_frame(bytes(heard.sample), heard.codec, network=network)
                raise LinkError(f"{what}.", where=heard.title, todo=todo)

    def _take(self, came: Frame | tuple[str, bytes]) -> None:
        if isinstance(came, tuple):
            name, data = came
            heard = self.links[name]
            heard.newest = data[-SHOWN:]
            heard.sample += data[: SAMPLE - len(heard.sample)]
            return
        link = self._link_of.get(next(iter(came.values), ""))
        if link is not None and self.links[link].before is None:  # a listener comes in the middle of one
            self.links[link].before = dict(self._reader.health.links[link].errors)
        self.values.update(came.values)
        self.came_at.update(dict.fromkeys(came.values, came.at))
        for name, value in came.values.items():
            if value is not None and name in self.arrivals:
                self.arrivals[name].append(came.at)
        if self.sensors.accepts(came, now_us()):
            self.sensors.frame(came)

    def age_s(self, channel: str, now: int) -> float | None:
        """Return the time since the last valid value of a channel, s; None before the first."""
        arrivals = self.arrivals[channel]
        return (now - arrivals[-1]) / 1e6 if arrivals else None

    def rate_hz(self, channel: str, now: int) -> float:
        """Return the recent rate of valid values, Hz; it falls towards 0 after the last one."""
        arrivals = self.arrivals[channel]
        if len(arrivals) < 2:
            return 0.0
        return (len(arrivals) - 1) / (max(now, arrivals[-1]) - arrivals[0]) * 1e6

    def state(self, channel: str, now: int) -> str:
        """Return "" if the channel has a fresh value, else the reason why it has none."""
        if channel not in self.values:
            return "nothing yet"
        if now - self.came_at[channel] >= self.sensors.now.readings.stale_after_us(channel):
            return "stale"
        return "invalid" if self.values[channel] is None else ""

    def measure(self, channel: str) -> Measure:
        """Return how the values of a channel are shown."""
        return self.sensors.now.readings.measures.get(channel, GAUGE_PRESSURE)

    def raw(self, channel: str) -> float | str | None:
        """Return the value that the source sent, or a word with its meaning, before scale and offset; for a channel of
        a codec, the value from the codec.
        """
        value, declared = self.values.get(channel), self.tool.channels.get(channel)
        if value is None or declared is None or declared.codec is not None:
            return value
        if word := declared.word(value):
            return word
        raw = round(declared.raw(value), 3)
        return int(raw) if raw.is_integer() else raw

    def errors(self) -> dict[str, dict[str, int]]:
        """Return the error counts of every link's decoder by kind; lost frames and reboots are among them."""
        found: dict[str, dict[str, int]] = {}
        for name, counters in self._reader.health.links.items():
            before = self.links[name].before or {}
            since = {kind: count - before.get(kind, 0) for kind, count in counters.errors.items()}
            counted = {"lost": counters.lost, "reboots": counters.reboots, **since}
            found[name] = {kind: count for kind, count in counted.items() if count}
        return found

    def evidence(self) -> dict[str, str]:
        """Return the evidence of each actuator."""
        names = (name for name, _ in self.tool.ordered)
        return {name: each.name for name, each in zip(names, self.sensors.now.evidence, strict=True)}

    def alarms(self, now: int) -> tuple[str, ...]:
        """Return the faults that devices report now, as sentences."""
        sensed = self.sensors.now
        return tuple([fault.as_alarm().text for fault in sensed.faults.standing(sensed.readings, now)])

    def lost(self) -> tuple[str, ...]:
        """Return in words why links that were open are lost, and what is wrong with the answers of single devices."""
        links = self._reader.health.links.values()
        lost = [link.error for link in links if link.error and link.opened]
        return (*lost, *(fault for link in links for fault in link.faults))

    def table(self, now: int) -> RenderableType:
        """Return the table for a terminal."""
        channels = Table("channel", "raw", "value", "age", "per second", "of", box=None, pad_edge=False)
        for name in self.channels:
            value, state, age_s = self.values.get(name), self.state(name, now), self.age_s(name, now)
            channels.add_row(
                name,
                "" if value is None else str(int(raw) if isinstance(raw := self.raw(name), bool) else raw),
                Text(state, style="red") if state else scaled(value, self.channels[name], self.measure(name)),
                "" if age_s is None else f"{age_s:.2f} s",
                f"{self.rate_hz(name, now):.1f}",
                ", ".join(self._users(name)),
            )
        actuators = Table("actuator", "evidence", box=None, pad_edge=False)
        for name, evidence in self.evidence().items():
            actuators.add_row(name, evidence)
        alarms = (Text(text, style="red") for text in self.alarms(now))
        sources = map(Text, self._sources())
        newest = (
            Text(f"newest bytes{name and f' of {name}'}  {each.newest.hex(' ')}", style="dim")
            for name, each in self.links.items()
        )
        return Group(*sources, "", channels, "", actuators, *alarms, "", *newest)

    def _sources(self) -> Iterator[str]:
        health, errors = self._reader.health, self.errors()
        for name, link in health.links.items():
            counted = ", ".join(f"{count} {kind}" for kind, count in errors[name].items()) or "no errors"
            told = link.error or f"{link.bytes} bytes, {link.frames} frames, {counted}"
            yield f"{name and f'{name}: '}{self.links[name].title}: {told}"
            yield from link.faults
        if inputs := health.inputs:
            told = inputs.error or f"{inputs.frames} frames, {inputs.edges} edges"
            yield f"inputs of the board: {told}"

    def _users(self, channel: str) -> Iterator[str]:
        for name, actuator in self.tool.ordered:
            if channel in kind_of(actuator).channel_names(actuator):
                yield name


def scaled(value: Value, kind: Kind, measure: Measure) -> str:
    """Return a value as text with its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if kind is Kind.CODE:
        return str(value)
    return "" if value is None else measure.text(value)
