"""Reads whatever brings the channels of a tool, and delivers their frames one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, cast

from end_effector_hal.codecs import board_inputs, codec_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.signals import Frame
from end_effector_hal.wires.inputs import InputsHealth, InputsReader
from end_effector_hal.wires.link import LinkHealth, LinkReader

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """A snapshot of each source: the links by name, and the inputs of the board; None: the tool has none."""

    links: Mapping[str, LinkHealth]
    inputs: InputsHealth | None


MOST_OVERTAKEN_US = 20_000
"""Threads of two sources take turns within this; what waited longer was heard long before (a relay's backlog)."""


class SensorReader:
    """Frames of the sensor links, of the inputs of the board, or of both.

    A source that is lost is tried again while the others go on. The callbacks come from threads of the reader, of
    frames and of changes one call at a time, and must not block for long.

    Args:
        description: the tool.
        on_frame: each frame, at once, in the order of their stamps: one that another source has overtaken by moments
            gets the stamp of that; one that is older keeps its own.
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
        self._last, self._closed = 0, False
        inputs = board_inputs(description)
        self._links = {
            name: self._reader(description, name, partial(on_bytes, name) if on_bytes else None)
            for name in links
        }
        changed = partial(self._changed, "inputs of the board")
        self._inputs = InputsReader(description, self._deliver, changed) if inputs else None

    def _reader(
        self, description: Description, name: str, on_bytes: Callable[[bytes], None] | None
    ) -> LinkReader:
        """Of the port; or of the line arbiter, where that masters the bus because it commands devices on it."""
        link, codec, connect = description.links[name], codec_of(description, name), None
        if name == description.bus:
            from end_effector_hal.codecs.modbus import RelayedBus
            from end_effector_hal.wires.bus import connect_relay, relay_path

            connect = partial(connect_relay, relay_path(socket_path(description)))
            codec = RelayedBus(cast("BusCodec", codec))
        return LinkReader(
            link.port,
            codec,
            link.baudrate,
            self._deliver,
            partial(self._changed, description.link_name(name) if name else "sensor link"),
            parity=link.parity,
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
        return SensorHealth(links, self._inputs.health if self._inputs else None)

    @property
    def _sources(self) -> tuple[LinkReader | InputsReader, ...]:
        return (*self._links.values(), *([self._inputs] if self._inputs else []))

    def _changed(self, source: str, health: LinkHealth | InputsHealth) -> None:
        if self._on_change:
            with self._change_lock:
                self._on_change(source, health)

    def _deliver(self, frame: Frame) -> None:
        with self._lock:
            if self._closed:
                return
            late_us = self._last - frame.at
            if 0 < late_us <= MOST_OVERTAKEN_US:  # of another source
                frame = replace(frame, at=self._last)
            # one that is older keeps its stamp: what judges frames refuses it, and says so
            self._last = max(self._last, frame.at)
            self._on_frame(frame)
