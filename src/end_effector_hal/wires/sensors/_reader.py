"""Reads whatever brings the channels of a tool, and delivers their frames one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, cast

from end_effector_hal.codecs import Codec, board_inputs, codec_of
from end_effector_hal.description import Description, Link, socket_path
from end_effector_hal.signals import Frame
from end_effector_hal.wires.inputs import InputsHealth, InputsReader
from end_effector_hal.wires.link import LinkHealth, LinkReader

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """A snapshot of each source; None: the tool has none."""

    link: LinkHealth | None
    inputs: InputsHealth | None


class SensorReader:
    """Frames of the sensor link, of the inputs of the board, or of both.

    Both callbacks come from threads of the reader, one call at a time, and must not block for long.

    Args:
        description: the tool.
        on_frame: each frame, at once; no frame is stamped before the one that was delivered before it.
        on_change: each change of the state of a source.

    Raises:
        UsageError: its codec cannot be used.
    """

    def __init__(
        self,
        description: Description,
        on_frame: Callable[[Frame], None],
        on_change: Callable[[LinkHealth | InputsHealth], None] | None = None,
    ) -> None:
        link = description.link
        self.where = link.port if link else description.sensors
        """Where the readings come from, for people."""
        self._on_frame, self._on_change = on_frame, on_change
        self._lock, self._change_lock = threading.Lock(), threading.Lock()
        self._last, self._closed = 0, False
        inputs = board_inputs(description)
        codec = codec_of(description) if link or not inputs else None
        self._link = self._reader(description, link, codec) if link and codec else None
        self._inputs = InputsReader(description, self._deliver, self._changed) if inputs else None

    def _reader(self, description: Description, link: Link, codec: Codec) -> LinkReader:
        """Of the port; or of the line arbiter, where that masters the bus because it commands devices on it."""
        connect = None
        if description.register_outputs:
            from end_effector_hal.codecs.modbus import RelayedBus
            from end_effector_hal.wires.bus import connect_relay, relay_path

            connect = partial(connect_relay, relay_path(socket_path(description)))
            codec = RelayedBus(cast("BusCodec", codec))
        return LinkReader(link.port, codec, link.baudrate, self._deliver, self._changed, link.parity, connect)

    def start(self) -> None:
        """Begin.

        Raises:
            LinkBusyError: somebody else reads the sensor link.
            LineBusyError: somebody else has an input line.
        """
        if self._link:
            self._link.start()
        if self._inputs:
            try:
                self._inputs.start()
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        """End; nothing is delivered after it."""
        self._closed = True
        for source in (self._link, self._inputs):
            if source:
                source.close()

    @property
    def health(self) -> SensorHealth:
        """As it is now; for any thread."""
        link, inputs = self._link, self._inputs
        return SensorHealth(link.health if link else None, inputs.health if inputs else None)

    def _changed(self, health: LinkHealth | InputsHealth) -> None:
        if self._on_change:
            with self._change_lock:
                self._on_change(health)

    def _deliver(self, frame: Frame) -> None:
        with self._lock:
            if self._closed:
                return
            if frame.at < self._last:  # of another source, and overtaken by microseconds
                frame = replace(frame, at=self._last)
            self._last = frame.at
            self._on_frame(frame)
