"""The sources of a tool's readings: its sensor links, the inputs of its board, or both."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, cast

from end_effector_hal.codecs import Codec, codec_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.signals import Frame
from end_effector_hal.wires import relay_path
from end_effector_hal.wires._relay import connect_relay
from end_effector_hal.wires.inputs import InputsHealth, InputsReader
from end_effector_hal.wires.inputs._relayed import RelayedInputs
from end_effector_hal.wires.link import LinkHealth
from end_effector_hal.wires.link._reader import LinkReader

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec

MOST_OVERTAKEN_US = 20_000
"""Longest delay between the threads of two sources, µs; a longer one has another cause (a relay's backlog)."""


class FrameOrder:
    """Gives a frame that newer frames have overtaken on their way the stamp of the newest one, so that it is judged
    after that one.

    A frame that other sources have overtaken by more than 20 ms, plus the waiting time of its source, keeps its stamp:
    the machine was late, and the frame is as old as its stamp. A frame that its own source has overtaken by more than
    that also keeps its stamp: the judge of frames refuses and reports it.
    """

    def __init__(self) -> None:
        self._last = 0
        self._came: dict[str, int] = {}
        self._given: dict[str, int] = {}

    def next(self, frame: Frame, source: str = "", waits_us: int = 0) -> Frame:
        """Return the frame with the stamp by which it is judged.

        Args:
            frame: the frame as received.
            source: name of its source; stamps of one source are in order, except for small differences.
            waits_us: how long its source may wait for other data after it has received the last data of the frame.
        """
        came = self._came.get(source, 0)
        if came - frame.at > MOST_OVERTAKEN_US + waits_us:
            return frame
        self._came[source] = max(came, frame.at)
        overtaken = 0 < self._last - frame.at <= MOST_OVERTAKEN_US + waits_us
        at = self._last if overtaken else max(frame.at, self._given.get(source, 0))
        self._given[source], self._last = at, max(self._last, at)
        return replace(frame, at=at) if at != frame.at else frame


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """A snapshot of all sources: the links by name, and the inputs of the board (None: the tool has none)."""

    links: Mapping[str, LinkHealth]
    inputs: InputsHealth | None


class SensorReader:
    """Delivers the frames of the sensor links, of the inputs of the board, or of both.

    A lost source is tried again while the others continue. The callbacks are called from threads of the reader (one
    frame at a time, one change at a time) and must not block for long.

    Args:
        description: the tool.
        on_frame: called at once with each frame. Frames of one source are in the order of their stamps. A frame that
            another source has overtaken by a moment gets the stamp of that source's frame; an older one keeps its own.
        on_change: called at each change of a source's state, with the name of the source for a sentence.
        on_bytes: called with the bytes of a link before they are decoded, and with the link's name.

    Raises:
        UsageError: a codec cannot be used.
    """

    def __init__(
        self,
        description: Description,
        on_frame: Callable[[Frame], None],
        on_change: Callable[[str, LinkHealth | InputsHealth], None] | None = None,
        on_bytes: Callable[[str, bytes], None] | None = None,
    ) -> None:
        links = description.links
        self.where = ", ".join(link.port for link in links.values()) or description.sensors
        """The source of the readings, for messages."""
        self._on_frame, self._on_change = on_frame, on_change
        self._lock, self._change_lock = threading.Lock(), threading.Lock()
        self._order, self._closed = FrameOrder(), False
        own = {name for name, each in description.channels.items() if each.on_board}
        relayed = description.arbiter_inputs
        own -= relayed
        self._links = {
            name: self._reader(description, name, partial(on_bytes, name) if on_bytes else None)
            for name in links
        }
        changed = partial(self._changed, "inputs of the board")
        self._inputs = InputsReader(description.with_inputs(own), self._deliver, changed) if own else None
        relay = relay_path(socket_path(description), "inputs")
        deliver = partial(self._deliver, source="relay")
        self._relayed = RelayedInputs(relay, relayed, deliver, changed) if relayed else None

    def _reader(
        self, description: Description, name: str, on_bytes: Callable[[bytes], None] | None
    ) -> LinkReader:
        """Return the reader of a link's port, or of the arbiter's relay if the arbiter commands devices on this bus."""
        link, codec, connect = description.links[name], codec_of(description, name), None
        deliver = partial(self._deliver, source=f"link {name}", waits_us=answers_us(codec))
        if name in description.buses:
            from end_effector_hal.codecs.modbus import RelayedBus
            from end_effector_hal.wires.bus import bus_relay

            connect = partial(connect_relay, bus_relay(description, socket_path(description), name))
            codec = RelayedBus(cast("BusCodec", codec), description.buses[name])
        return LinkReader(
            link.port,
            codec,
            link.baudrate,
            deliver,
            partial(self._changed, description.link_name(name) if name else "sensor link"),
            parity=link.parity,
            stopbits=link.stopbits or 1,
            on_bytes=on_bytes,
            connect=connect,
        )

    def start(self) -> None:
        """Start reading.

        Raises:
            LinkBusyError: another process reads a sensor link.
            LineBusyError: another process has an input line.
        """
        try:
            for source in self._sources:
                source.start()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Stop reading; nothing is delivered afterwards."""
        self._closed = True
        for source in self._sources:
            source.close()

    @property
    def health(self) -> SensorHealth:
        """The present health; may be read from any thread."""
        links = {name: link.health for name, link in self._links.items()}
        found = [each.health for each in (self._inputs, self._relayed) if each]
        return SensorHealth(links, together(found) if found else None)

    @property
    def _sources(self) -> tuple[LinkReader | InputsReader | RelayedInputs, ...]:
        board = [each for each in (self._inputs, self._relayed) if each]
        return (*self._links.values(), *board)

    def _changed(self, source: str, health: LinkHealth | InputsHealth) -> None:
        if self._on_change:
            with self._change_lock:
                self._on_change(source, health)

    def _deliver(self, frame: Frame, source: str = "", waits_us: int = 0) -> None:
        with self._lock:
            if self._closed:
                return
            self._on_frame(self._order.next(frame, source, waits_us))


LONGEST_ANSWERS_US = 150_000


def answers_us(codec: Codec) -> int:
    """Return how long a cycle of Modbus may wait for dead devices after the others have answered, µs."""
    reads, timeout_us = getattr(codec, "reads", ()), getattr(codec, "timeout_us", 0)
    return min(len(reads) * int(timeout_us), LONGEST_ANSWERS_US)


def together(found: Sequence[InputsHealth]) -> InputsHealth:
    """Return the combined health of all inputs of the board, read by this process or by the line arbiter."""
    frames = [each.last_frame for each in found if each.last_frame is not None]
    counted = ("opened", "frames", "edges", "lost")
    counters = {name: sum(getattr(each, name) for each in found) for name in counted}
    error = " ".join(each.error for each in found if each.error)
    since = max(each.since for each in found if each.error or not error)
    return InputsHealth(error=error, since=since, last_frame=max(frames, default=None), **counters)
