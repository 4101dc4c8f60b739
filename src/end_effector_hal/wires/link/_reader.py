"""Reads a sensor link for ever: one thread, blocked until bytes arrive or something is to be asked."""

from __future__ import annotations

import logging
import os
import select
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress

import serial

from end_effector_hal.errors import LinkBusyError, LinkError
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.codecs import Codec, PolledDecoder, asks, get_codec, parity_of
from end_effector_hal.wires.frame import Frame
from end_effector_hal.wires.link._health import LinkHealth, LinkState
from end_effector_hal.wires.link._port import open_port

_log = logging.getLogger("end_effector_hal.wires")
FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 5.0


class LinkReader:
    """Delivers the frames of a port, and opens it again when it is lost (after 0.1 s, doubling up to 5 s).

    Both callbacks are called in the reader's thread and must not block for long; an exception is logged.

    Args:
        port: device, or a link to it.
        codec: or its name.
        baudrate: default: that of the codec.
        on_frame: each frame, at once; ``frame.at`` is the time at which its last byte was read.
        on_change: each change of state, and of the error while it is down.
    """

    def __init__(
        self,
        port: str,
        codec: Codec | str,
        baudrate: int | None = None,
        on_frame: Callable[[Frame], None] = lambda frame: None,
        on_change: Callable[[LinkHealth], None] | None = None,
    ) -> None:
        self._port = port
        codec = get_codec(codec) if isinstance(codec, str) else codec
        self._baudrate, self._parity = baudrate or codec.baudrate, parity_of(codec)
        self._decoder = codec.decoder()
        self._on_frame, self._on_change = on_frame, on_change
        self._state, self._since, self._error, self._opened = LinkState.OPENING, now_us(), "", 0
        self._last_frame: int | None = None
        self._wait_s = FIRST_WAIT_S
        self._first: serial.Serial | None = None
        self._thread: threading.Thread | None = None

    def start(self, patience_s: float = 1.0) -> None:
        """Begin; a port that is not there yet is no error.

        Args:
            patience_s: how long somebody else may still have the port: a predecessor that is ending.

        Raises:
            LinkBusyError: somebody else keeps it; says who. Nothing was started.
        """
        self._first = self._claimed(now_us() + round(patience_s * 1e6))
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, name=f"link {self._port}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End and give the port back; nothing is delivered after it (unless called from a callback)."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.write(self._wake, b"x")
        if thread is not threading.current_thread():
            thread.join()

    def __enter__(self) -> LinkReader:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def health(self) -> LinkHealth:
        """As it is now; may be read in any thread."""
        decoder = self._decoder
        return LinkHealth(
            state=self._state,
            since=self._since,
            error=self._error,
            last_frame=self._last_frame,
            opened=self._opened,
            bytes=decoder.bytes,
            frames=decoder.frames,
            lost=decoder.lost,
            reboots=decoder.reboots,
            errors=dict(decoder.errors),
        )

    def _run(self) -> None:
        try:
            while self._thread is not None:
                try:
                    first, self._first = self._first, None
                    with first or self._open() as port:
                        self._opened += 1
                        self._change(LinkState.SILENT)
                        self._read(port)
                except (LinkError, OSError) as error:
                    text = str(error) if isinstance(error, LinkError) else self._lost(error)
                    self._change(LinkState.DOWN, text)
                    self._sleep()
        finally:
            os.close(self._wake_read)
            os.close(self._wake)

    def _open(self) -> serial.Serial:
        return open_port(self._port, self._baudrate, parity=self._parity)

    def _claimed(self, until: int) -> serial.Serial | None:
        """The port; None while there is none that can be opened."""
        while True:
            try:
                return self._open()
            except LinkBusyError:
                if now_us() >= until:
                    raise
            except LinkError:
                return None  # the thread tries again, and says why
            time.sleep(FIRST_WAIT_S)

    def _read(self, port: serial.Serial) -> None:
        """Until the end; raises OSError when the port is lost."""
        fd, decoder = port.fileno(), self._decoder
        poller = decoder if asks(decoder) else None
        while self._wake_read not in (
            ready := select.select([fd, self._wake_read], [], [], _wait(poller))[0]
        ):
            if fd in ready:
                data = os.read(fd, 4096)
                at = now_us()
                if not data:
                    raise OSError("end of file")
                self._deliver(decoder.feed(data, at))
            if poller is not None:
                polled = poller.poll(now_us())
                with suppress(BlockingIOError):  # no room: a request that is not answered
                    os.write(fd, polled.data)
                self._deliver(polled.frames)

    def _deliver(self, frames: Iterable[Frame]) -> None:
        for frame in frames:
            self._wait_s, self._last_frame = FIRST_WAIT_S, frame.at
            self._change(LinkState.UP)
            self._call(self._on_frame, frame)

    def _lost(self, error: OSError) -> str:
        return str(
            LinkError(
                f"the port was lost: {error.strerror or error}.",
                where=self._port,
                todo="It is opened again as soon as it is back.",
            )
        )

    def _sleep(self) -> None:
        select.select([self._wake_read], [], [], self._wait_s)
        self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def _change(self, state: LinkState, error: str = "") -> None:
        if (state, error) == (self._state, self._error):
            return
        if state is not self._state:
            self._since = now_us()
        self._state, self._error = state, error
        if self._on_change:
            self._call(self._on_change, self.health)

    def _call(self, callback: Callable[..., None], argument: object) -> None:
        try:
            callback(argument)
        except Exception:  # noqa: BLE001 a callback may raise anything; the next frame counts
            _log.exception("a listener of %s failed", self._port)


def _wait(poller: PolledDecoder | None) -> float | None:
    """Seconds until something is to be asked."""
    return None if poller is None else max(0, poller.due - now_us()) / 1_000_000
