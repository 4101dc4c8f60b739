"""Reads whatever brings the channels of a tool, and delivers their frames one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, cast

from end_effector_hal.codecs import Codec, codec_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.signals import Frame
from end_effector_hal.wires import connect_relay, relay_path
from end_effector_hal.wires.inputs import InputsHealth, InputsReader, RelayedInputs
from end_effector_hal.wires.link import LinkHealth, LinkReader

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec


MOST_OVERTAKEN_US = 20_000
"""Threads of two sources take turns within this; what waited longer was heard long before (a relay's backlog)."""


class FrameOrder:
    """Gives a frame that was overtaken on its way the stamp of the newest one: it is news, and is judged after that.

    A frame that other sources have overtaken by more than 20 ms, and what its source waits, keeps its stamp: the
    machine was late, and the frame is as old as it is. One that its own source has overtaken by more than that keeps
    its stamp as well: what judges frames refuses it, and says so.
    """

    def __init__(self) -> None:
        self._last = 0
        self._came: dict[str, int] = {}
        self._given: dict[str, int] = {}

    def next(self, frame: Frame, source: str = "", waits_us: int = 0) -> Frame:
        """The frame as it is judged.

        Args:
            frame: as it came.
            source: who brought it; stamps of one source are in order, but for moments.
            waits_us: so long its source may go on waiting for others after it has heard the last of it.
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
    """A snapshot of each source: the links by name, and the inputs of the board; None: the tool has none."""

    links: Mapping[str, LinkHealth]
    inputs: InputsHealth | None


class SensorReader:
    """Frames of the sensor links, of the inputs of the board, or of both.

    A source that is lost is tried again while the others go on. The callbacks come from threads of the reader, of
    frames and of changes one call at a time, and must not block for long.

    Args:
        description: the tool.
        on_frame: each frame, at once, those of one source in the order of their stamps: one that another source has
            overtaken by moments gets the stamp of that; one that is older keeps its own.
        on_change: each change of the state of a source, with its name for a sentence.
        on_bytes: whatever comes over a link, by its name, before it is decoded.

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
        """Where the readings come from, for people."""
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
        """Of the port; or of the line arbiter, where that masters the bus because it commands devices on it."""
        link, codec, connect = description.links[name], codec_of(description, name), None
        deliver = partial(self._deliver, source=f"link {name}", waits_us=answers_us(codec))
        if name in description.buses:
            from end_effector_hal.codecs.modbus import RelayedBus
            from end_effector_hal.wires.bus import bus_relay

            connect = partial(connect_relay, bus_relay(description, socket_path(description), name))
            codec = RelayedBus(cast("BusCodec", codec))
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
        """Begin.

        Raises:
            LinkBusyError: somebody else reads a sensor link.
            LineBusyError: somebody else has an input line.
        """
        try:
            for source in self._sources:
                source.start()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End; nothing is delivered after it."""
        self._closed = True
        for source in self._sources:
            source.close()

    @property
    def health(self) -> SensorHealth:
        """As it is now; for any thread."""
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
    """How long a cycle of Modbus may wait for devices that are dead, when the others have answered already."""
    reads, timeout_us = getattr(codec, "reads", ()), getattr(codec, "timeout_us", 0)
    return min(len(reads) * int(timeout_us), LONGEST_ANSWERS_US)


def together(found: Sequence[InputsHealth]) -> InputsHealth:
    """The health of all inputs of the board, read here or by the line arbiter."""
    frames = [each.last_frame for each in found if each.last_frame is not None]
    counted = ("opened", "frames", "edges", "lost")
    counters = {name: sum(getattr(each, name) for each in found) for name in counted}
    error = " ".join(each.error for each in found if each.error)
    since = max(each.since for each in found if each.error or not error)
    return InputsHealth(error=error, since=since, last_frame=max(frames, default=None), **counters)
