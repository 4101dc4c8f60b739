"""Reads a sensor link continuously, in one thread that blocks until bytes arrive or a request is due."""

from __future__ import annotations

import logging
import os
import select
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from enum import Enum

from end_effector_hal.codecs import Codec, Counters, get_codec, parity_of
from end_effector_hal.errors import LinkBusyError, LinkError
from end_effector_hal.plugins import named
from end_effector_hal.signals import Frame
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.link._guard import CodecCalls, CodecFailure, GuardedDecoder
from end_effector_hal.wires.link._port import DescriptorPort, OpenPort, WirePort, open_wire


class LinkState(Enum):
    """The state of the port; whether readings are stale is judged by time, elsewhere."""

    OPENING = "opening"
    """Not opened yet."""
    SILENT = "silent"
    """Open; no frame has been received since."""
    UP = "up"
    """Open; at least one frame has been received, the last one at ``last_frame``."""
    DOWN = "down"
    """The port could not be opened, or was lost; it is tried again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkHealth(Counters):
    """A snapshot of a link.

    Attributes:
        state: see `LinkState`.
        since: time at which the state began, µs.
        error: why the link is down, a sentence; else "".
        last_frame: time of the last frame, µs; None: there was none.
        faults: faults in the answers of single devices, sentences.
        opened: how many times the port was opened.
        bytes, frames, lost, reboots, errors: counters of the decoders since the start, see `Decoder`;
            ``errors["codec"]``: how often the codec itself failed.
    """

    state: LinkState
    since: int
    error: str = ""
    last_frame: int | None = None
    opened: int = 0
    faults: tuple[str, ...] = ()


_log = logging.getLogger("end_effector_hal.wires")
FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 5.0
CLOSE_S = 2.0
LOOK_S = 0.03
"""Longest wait for data, s: a process that was stopped for a while can then detect it."""
FULL_BYTES = 4000
"""A read of so many bytes means that the kernel's buffer (4,095) was full, and that their age is unknown."""


class LinkReader:
    """Delivers the frames of a port, and opens the port again when it is lost (after 0.1 s, doubling up to 5 s).

    Both callbacks are called in the reader's thread and must not block for long; an exception is logged. After any
    failure of the codec or the port the link is down with the reason, and is tried again, with a new decoder.

    Args:
        port: device, or a link to it; or an address in a network.
        codec: the codec, or its name.
        baudrate, parity: default: those of the codec.
        stopbits: number of stop bits after each byte.
        on_frame: called at once with each frame; ``frame.at`` is the time at which its last byte was read or, if
            several frames waited to be read, at which it must have arrived.
        on_change: called at each change of the state, of the error while the link is down, and of the faults.
        on_bytes: called with the bytes before they are decoded.
        connect: opens another source instead of the port; raises LinkError.
    """

    def __init__(
        self,
        port: str,
        codec: Codec | str,
        baudrate: int | None = None,
        on_frame: Callable[[Frame], None] = lambda frame: None,
        on_change: Callable[[LinkHealth], None] | None = None,
        parity: str | None = None,
        on_bytes: Callable[[bytes], None] | None = None,
        connect: Callable[[], OpenPort] | None = None,
        stopbits: int = 1,
    ) -> None:
        self._port, self._connect = port, connect
        self._codec = get_codec(codec) if isinstance(codec, str) else codec
        self._baudrate, self._parity, self._stopbits = baudrate, parity, stopbits
        self._calls = CodecCalls(port)
        self._decoder: GuardedDecoder | None = None
        self._before = Counters()  # of decoders that have failed
        self._on_frame, self._on_change, self._on_bytes = on_frame, on_change, on_bytes
        self._state, self._since, self._error, self._opened = LinkState.OPENING, now_us(), "", 0
        self._last_frame: int | None = None
        self._faults: tuple[str, ...] = ()
        self._wait_s = FIRST_WAIT_S
        self._first: WirePort | None = None
        self._open_now: WirePort | None = None
        self._thread: threading.Thread | None = None

    def start(self, patience_s: float = 1.0) -> None:
        """Start reading; a missing port or a failing codec is not an error here.

        Args:
            patience_s: longest wait for another process (a predecessor that is ending) to release the port.

        Raises:
            LinkBusyError: another process keeps the port; the message names it. Nothing was started.
        """
        self._first = self._claimed(now_us() + round(patience_s * 1e6))
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, name=f"link {self._port}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop reading and close the port; nothing is delivered afterwards (unless called from a callback).

        If a codec or a callback does not return, its thread is left behind; the caller does not wait for it, and the
        port is closed.
        """
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.close(self._wake)  # wakes the thread, which may have seen its end already and closes the other end
        if thread is threading.current_thread() or thread.ident is None:  # it could not be started
            return
        thread.join(CLOSE_S)
        if thread.is_alive():
            hung = self._calls.hung
            _log.error("%s", hung[0] if hung else f"the link {self._port} does not end; it is left behind.")
            self._give_back()

    def __enter__(self) -> LinkReader:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def health(self) -> LinkHealth:
        """The present health; may be read from any thread. The codec is not called for it."""
        state, since, error = self._state, self._since, self._error
        if hung := self._calls.hung:
            state, (error, since) = LinkState.DOWN, hung
        counters = self._before if self._decoder is None else self._before.plus(self._decoder.counters)
        return LinkHealth(
            state=state,
            since=since,
            error=error,
            last_frame=self._last_frame,
            opened=self._opened,
            faults=self._faults,
            **asdict(counters),
        )

    @property
    def _closed(self) -> bool:
        """Whether this thread must end, or was left behind."""
        return self._thread is not threading.current_thread()

    def _run(self) -> None:
        wake_read = self._wake_read
        try:
            while not self._closed:
                try:
                    self._stay_open()
                except BaseException as error:  # noqa: BLE001 a codec, a driver: this thread outlives them all
                    self._fail(error)
        finally:
            os.close(wake_read)

    def _stay_open(self) -> None:
        """Open the port and read until the end; raises any error that ends the reading earlier."""
        first, self._first = self._first, None
        with closing(first or self._open()) as port:
            self._open_now = port
            while port.connecting:
                if self._wake_read in select.select([port.fileno(), self._wake_read], [], [])[0]:
                    return
                port.establish()
            if self._decoder is None:
                self._decoder = GuardedDecoder(self._codec, self._calls)
            self._opened += 1
            self._change(LinkState.SILENT)
            self._read(port, self._decoder)

    def _fail(self, error: BaseException) -> None:
        if self._closed:
            return
        if isinstance(error, CodecFailure):
            # what it knows is worth nothing now; what it has counted stays
            counted = self._decoder.counters if self._decoder is not None else Counters()
            self._before = self._before.plus(counted).plus(Counters(errors={"codec": 1}))
            self._decoder = None
        self._change(LinkState.DOWN, self._explained(error))
        self._sleep()

    def _open(self) -> WirePort:
        if self._connect:
            return DescriptorPort(self._connect())
        baudrate = self._baudrate or self._calls.run("baudrate", lambda: int(self._codec.baudrate))
        parity = self._parity or self._calls.run("parity", lambda: parity_of(self._codec))
        return open_wire(self._port, baudrate, parity=parity, stopbits=self._stopbits)

    def _claimed(self, until: int) -> WirePort | None:
        """Return the port; None: no port can be opened yet."""
        while True:
            try:
                return self._open()
            except LinkBusyError:
                if now_us() >= until:
                    raise
            except (Exception, SystemExit):  # noqa: BLE001 the thread tries again, and says why
                return None
            time.sleep(FIRST_WAIT_S)

    def _read(self, port: WirePort, decoder: GuardedDecoder) -> None:
        """Read until the end; raises OSError when the port is lost, LinkError when the codec fails."""
        fd, looked_at = port.fileno(), now_us()
        while not self._closed:
            begun, wait_s = now_us(), decoder.wait_s()
            wait_s = LOOK_S if wait_s is None else min(wait_s, LOOK_S)
            ready = select.select([fd, self._wake_read], [], [], wait_s)[0]
            if self._wake_read in ready:
                return
            full = False
            if fd in ready:
                begun = now_us()  # what comes from now on is in the next read
                data = port.read()
                if self._on_bytes and data:
                    self._call(self._on_bytes, data)
                full = len(data) >= FULL_BYTES and not os.isatty(fd)
                if full or len(data) < FULL_BYTES:
                    self._deliver(decoder.feed(data, looked_at))
                else:
                    _throw_away(fd)
                    self._before = self._before.plus(Counters(errors={"late": len(data)}))
            looked_at = looked_at if full else begun  # what is left of a full read has waited as long
            if decoder.asks and not self._closed:
                polled = decoder.poll()
                if self._closed:
                    return
                if polled.data:
                    port.write(polled.data)
                self._deliver(polled.frames)
            if decoder.faults != self._faults:
                self._faults = decoder.faults
                if self._on_change:
                    self._call(self._on_change, self.health)

    def _deliver(self, frames: Iterable[Frame]) -> None:
        for frame in frames:
            if self._closed:
                return
            self._wait_s, self._last_frame = FIRST_WAIT_S, frame.at
            self._change(LinkState.UP)
            self._call(self._on_frame, frame)

    def _give_back(self) -> None:
        """Close the port of a thread that is left behind and no longer uses it."""
        port, self._open_now = self._open_now, None
        if port is not None:
            with suppress(Exception):
                port.close()

    def _explained(self, error: BaseException) -> str:
        if isinstance(error, LinkError):
            return str(error)
        what = (error.strerror or str(error)) if isinstance(error, OSError) else named(error)
        todo = "It is opened again as soon as it is back."
        return str(LinkError(f"the port was lost: {what}.", where=self._port, todo=todo))

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
        except BaseException:  # noqa: BLE001 a callback may raise anything; the next frame counts
            _log.exception("a listener of %s failed", self._port)


def _throw_away(fd: int) -> None:
    """Discard the data that waits to be read at a terminal."""
    import termios  # what needs no port needs no POSIX

    termios.tcflush(fd, termios.TCIFLUSH)
