"""Input lines of the board that the line arbiter reads and relays over its Unix socket."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Collection
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from end_effector_hal.errors import LinkError, UsageError
from end_effector_hal.signals import Frame
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires._relay import connect_relay
from end_effector_hal.wires.rpc import Client, record_line
from end_effector_hal.wires.rpc._messages import read_message

from ._reader import InputsHealth

_log = logging.getLogger("end_effector_hal.wires")
AGAIN_S = 0.1
CLOSE_S = 2.0
READS = "reads these inputs, does not relay them"


@dataclass(frozen=True, slots=True)
class InputsRecord:
    """The values of inputs, and the time at which they were read (µs)."""

    at: Annotated[int, Field(ge=0)]
    content: dict[str, Any]


def inputs_record(frame: Frame) -> bytes:
    """Return the record of a frame of inputs."""
    return record_line("inputs", frame.at, frame.values)


def read_inputs_record(line: bytes, channels: Collection[str], now: int) -> Frame | None:
    """Return the frame of a record, with these channels only; None: the record has none of them or is not valid."""
    try:
        record = read_message(InputsRecord, line, "record")
    except UsageError:
        return None
    values = {
        name: value for name, value in record.content.items() if name in channels and type(value) is bool
    }
    return Frame(min(record.at, now), None, None, values) if values else None


class RelayedInputs:
    """Delivers the frames of inputs that the line arbiter reads; connects again until the arbiter is there.

    Both callbacks are called in the reader's thread and must not block for long.

    Args:
        path: the socket of the relay.
        channels: the expected channels.
        on_frame: called at once with each frame.
        on_change: called at each change of the error.
    """

    def __init__(
        self,
        path: Path,
        channels: Collection[str],
        on_frame: Callable[[Frame], None],
        on_change: Callable[[InputsHealth], None],
    ) -> None:
        self._path, self._channels = path, frozenset(channels)
        self._on_frame, self._on_change = on_frame, on_change
        self._error, self._since = "", now_us()
        self._last_frame: int | None = None
        self._opened = self._frames = 0
        self._ended = threading.Event()
        self._relay: Client | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start receiving; a missing arbiter is not an error here."""
        self._thread = threading.Thread(target=self._run, name="relayed inputs", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop receiving; nothing is delivered afterwards."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._ended.set()
        if (relay := self._relay) is not None:
            relay.abort()
        if thread is not threading.current_thread() and thread.ident is not None:
            thread.join(CLOSE_S)

    @property
    def health(self) -> InputsHealth:
        """The present health; may be read from any thread."""
        return InputsHealth(
            error=self._error,
            since=self._since,
            last_frame=self._last_frame,
            opened=self._opened,
            frames=self._frames,
        )

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                with closing(connect_relay(self._path, READS)) as self._relay:
                    self._opened += 1
                    self._judge("")
                    self._read(self._relay)
            except LinkError as error:
                self._judge(str(error))
            except Exception as error:  # noqa: BLE001 neither a lack of files nor a callback ends this thread
                _log.exception("the inputs that the line arbiter reads are not delivered")
                self._judge(f"the inputs are not delivered: {error}")
            self._ended.wait(AGAIN_S)

    def _read(self, relay: Client) -> None:
        """Receive frames until the relay ends."""
        while not self._ended.is_set():
            try:
                line = relay.receive()
            except OSError:
                self._judge("the line arbiter, which reads these inputs, has gone.")
                return
            frame = read_inputs_record(line, self._channels, now_us())
            if frame is not None and not self._ended.is_set():
                self._frames += 1
                self._last_frame = frame.at
                self._on_frame(frame)

    def _judge(self, error: str) -> None:
        if error != self._error and not self._ended.is_set():
            self._error, self._since = error, now_us()
            try:
                self._on_change(self.health)
            except Exception:  # noqa: BLE001
                _log.exception("a listener to the inputs failed")
