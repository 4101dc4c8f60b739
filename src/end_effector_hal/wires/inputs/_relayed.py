"""Input lines of the board that the line arbiter reads: what it reads, over its Unix socket."""

from __future__ import annotations

import json
import logging
import os
import select
import socket
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import LinkError
from end_effector_hal.signals import Frame
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires._relay import connect_relay

from ._reader import InputsHealth

_log = logging.getLogger("end_effector_hal.wires")
AGAIN_S = 0.1
CLOSE_S = 2.0
LONGEST = 65_536
"""Bytes of a record."""
READS = "reads these inputs, does not hand them on"


def inputs_record(frame: Frame) -> bytes:
    """A frame of inputs for the relay."""
    return json.dumps({"at": frame.at, "values": dict(frame.values)}).encode() + b"\n"


def read_inputs_record(record: bytes, channels: Collection[str], now: int) -> Frame | None:
    """The frame of a record, with these channels only; None: it is none."""
    try:
        given = json.loads(record)
        at, found = given["at"], given["values"]
        values = {name: found[name] for name in channels if type(found.get(name)) is bool}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return Frame(min(at, now), None, None, values) if values and type(at) is int and at >= 0 else None


class RelayedInputs:
    """Delivers the frames of inputs that the line arbiter reads; it is looked for again until it is there.

    Both callbacks are called in the reader's thread and must not block for long.

    Args:
        path: of the relay.
        channels: that are expected.
        on_frame: each frame, at once.
        on_change: each change of what cannot be read.
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
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin; an arbiter that is not there yet is no error."""
        self._wake_read, self._wake = os.pipe2(os.O_CLOEXEC)
        self._thread = threading.Thread(target=self._run, name="relayed inputs", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End; nothing is delivered after it."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._ended.set()
        os.close(self._wake)
        if thread is not threading.current_thread() and thread.ident is not None:
            thread.join(CLOSE_S)

    @property
    def health(self) -> InputsHealth:
        """As it is now; may be read in any thread."""
        return InputsHealth(
            error=self._error,
            since=self._since,
            last_frame=self._last_frame,
            opened=self._opened,
            frames=self._frames,
        )

    def _run(self) -> None:
        try:
            while not self._ended.is_set():
                try:
                    with connect_relay(self._path, READS) as relay:
                        self._opened += 1
                        self._judge("")
                        self._read(relay)
                    self._judge("the line arbiter, which reads these inputs, has gone.")
                except LinkError as error:
                    self._judge(str(error))
                except Exception as error:  # noqa: BLE001 this thread outlives a lack of files, and its callbacks
                    _log.exception("the inputs that the line arbiter reads are not delivered")
                    self._judge(f"they are not delivered: {error}")
                select.select([self._wake_read], [], [], AGAIN_S)
        finally:
            os.close(self._wake_read)

    def _read(self, relay: socket.socket) -> None:
        """Until it ends."""
        rest = b""
        while not self._ended.is_set():
            ends: list[int | socket.socket] = [relay, self._wake_read]
            if relay not in select.select(ends, [], [])[0]:
                continue
            with suppress(BlockingIOError, ConnectionError):
                data = relay.recv(LONGEST)
                *records, rest = (rest + data).split(b"\n")
                for frame in self._frames_of(records):
                    self._frames += 1
                    self._last_frame = frame.at
                    self._on_frame(frame)
                if data and len(rest) < LONGEST:
                    continue
            return

    def _frames_of(self, records: list[bytes]) -> Iterator[Frame]:
        for record in records:
            frame = read_inputs_record(record, self._channels, now_us())
            if frame is not None and not self._ended.is_set():
                yield frame

    def _judge(self, error: str) -> None:
        if error != self._error and not self._ended.is_set():
            self._error, self._since = error, now_us()
            try:
                self._on_change(self.health)
            except Exception:  # noqa: BLE001
                _log.exception("a listener to the inputs failed")
