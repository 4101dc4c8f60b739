"""Reads the inputs of a board continuously, in one thread that blocks until an edge or the next reading is due."""

from __future__ import annotations

import logging
import os
import select
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.codecs import board_inputs
from end_effector_hal.description import Description, Inputs
from end_effector_hal.errors import LineBusyError, ReportedError
from end_effector_hal.plugins import named
from end_effector_hal.signals import Frame, Value
from end_effector_hal.wires._clock import Backoff, now_us

from ._analog import AnalogReader
from ._gpiod import GpiodInputLines
from ._lines import InputLines, LineEdge, input_lines
from ._virtual import VirtualInputLines

_log = logging.getLogger("end_effector_hal.wires")
MOST_EDGES = 20
"""Most edges of one line between two readings; a line that changes more often is only read once per period."""
SLOW_US = 5_000
"""Longest time to read one frame from a converter, µs; then the values so far are delivered, the rest later."""
CLOSE_S = 2.0
RETRY_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class InputsHealth:
    """A snapshot of the inputs.

    Attributes:
        error: the inputs that cannot be read now, and why; sentences, else "".
        since: time at which this state began, µs.
        last_frame: time of the last frame, µs; None: there was none.
        opened: how many times the lines were claimed.
        frames: number of frames since the start.
        edges: number of edges of all lines since the start.
        lost: how often edges were lost and the levels were read again.
    """

    error: str = ""
    since: int
    last_frame: int | None = None
    opened: int = 0
    frames: int = 0
    edges: int = 0
    lost: int = 0


class InputsReader:
    """Delivers frames of the inputs: at the start, with each period, and at each edge of a digital line.

    A frame contains only values that were read for it: an edge gives a frame of the channels of its line. Lines that
    cannot be claimed, or are lost, are tried again (after 0.1 s, doubling up to 5 s); until then their channels are in
    no frame. An analog channel that cannot be read is invalid. Both callbacks are called in the reader's thread and
    must not block for long; an exception is logged.

    Args:
        description: the tool; at least one of its channels is an input of the board.
        on_frame: called at once with each frame.
        on_change: called at each change of the set of inputs that cannot be read.
        lines: the lines to read; default: those of the description.
    """

    def __init__(
        self,
        description: Description,
        on_frame: Callable[[Frame], None] = lambda frame: None,
        on_change: Callable[[InputsHealth], None] | None = None,
        *,
        lines: InputLines | None = None,
    ) -> None:
        self._on_frame, self._on_change = on_frame, on_change
        inputs = board_inputs(description)
        self._period_us = inputs.period_us if inputs else 0
        self._inputs = input_lines(description)
        self._lines = lines or lines_of(description)
        self._by_line = {
            line: {
                name: each
                for name, each in description.channels.items()
                if each.digital and each.digital.line == line
            }
            for line in self._inputs
        }
        analog = {name: each for name, each in description.channels.items() if each.analog}
        self._analog_names = tuple(analog)
        folder = (description.inputs or Inputs()).iio
        self._analog = AnalogReader(Path(folder), analog)
        self._open = False
        self._backoff = Backoff()
        self._lines_error = self._noise_error = self._noisy = ""
        self._count = Counter[str]()
        self._error, self._since = "", now_us()
        self._last_frame: int | None = None
        self._opened = self._frames = self._edges = self._lost = 0
        self._thread: threading.Thread | None = None

    def start(self, patience_s: float = 1.0) -> None:
        """Start reading; a missing chip or device is not an error here.

        Args:
            patience_s: longest wait for another process (a predecessor that is ending) to release a line.

        Raises:
            LineBusyError: another process keeps a line; the message names it. Nothing was started.
        """
        until = time.monotonic() + patience_s
        while self._inputs and not self._open:
            try:
                self._claim()
            except LineBusyError:
                if time.monotonic() >= until:
                    raise
                time.sleep(RETRY_S)
            except Exception as error:  # noqa: BLE001 the thread tries again, and says why
                self._fail(error)
                break
        self._wake_read, self._wake = os.pipe2(os.O_CLOEXEC)
        self._thread = threading.Thread(target=self._run, name="inputs", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop reading and release the lines; nothing is delivered afterwards (unless called from a callback).

        If a driver or a callback does not return, its thread is left behind.
        """
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.close(self._wake)
        if thread is threading.current_thread() or thread.ident is None:  # it could not be started
            return
        thread.join(CLOSE_S)
        if thread.is_alive():
            _log.error("The reader of the inputs does not end; it is left behind.")

    def __enter__(self) -> InputsReader:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def health(self) -> InputsHealth:
        """The present health; may be read from any thread."""
        return InputsHealth(
            error=self._error,
            since=self._since,
            last_frame=self._last_frame,
            opened=self._opened,
            frames=self._frames,
            edges=self._edges,
            lost=self._lost,
        )

    @property
    def _closed(self) -> bool:
        return self._thread is not threading.current_thread()

    def _run(self) -> None:
        wake_read, due = self._wake_read, now_us()
        try:
            while not self._closed:
                now = now_us()
                if now >= due:
                    self._sample()
                    due = max(due + self._period_us, now_us())  # what was slept through is left out
                try:
                    self._wait(wake_read, due)
                except Exception as error:  # noqa: BLE001 this thread outlives whatever its lines do
                    self._fail(error)
                self._take_edges()
        finally:
            os.close(wake_read)
            self._release()

    def _wait(self, wake_read: int, due: int) -> None:
        """Wait until there is work; a line that changes too often is ignored until the next reading."""
        fds, early = (self._lines.fds(), self._lines.due()) if self._open and not self._noisy else ((), None)
        until = due if early is None else min(due, early)
        select.select([*fds, wake_read], [], [], max(0.0, (until - now_us()) / 1e6))

    def _sample(self) -> None:
        """Read all inputs."""
        if self._inputs and not self._open and self._backoff.is_due():
            try:
                self._claim()
            except Exception as error:  # noqa: BLE001 a driver may raise anything; it is tried again
                self._fail(error)
        self._take_edges()
        self._noise_error = _noise(self._noisy, self._period_us) if self._noisy else ""
        self._count.clear()
        self._noisy = ""
        values: dict[str, Value] = {}
        began = now_us()
        for name in self._analog_names:
            values[name] = self._analog.read(name)
            self._take_edges()
            if now_us() - began > SLOW_US:
                self._deliver(values, now_us())
                values, began = {}, now_us()
        # the time before they are read: an edge that comes while this thread waits is later than they are
        at = now_us()
        self._deliver(values | self._levels(), at)
        self._judge()

    def _levels(self) -> dict[str, Value]:
        values: dict[str, Value] = {}
        if self._open:
            try:
                for line, high in self._lines.levels().items():
                    values |= self._values(line, high)
            except Exception as error:  # noqa: BLE001
                self._fail(error)
        return values

    def _take_edges(self) -> None:
        if not self._open:
            return
        try:
            came = self._lines.edges()
        except Exception as error:  # noqa: BLE001
            self._fail(error)
            return
        for edge in came.edges:
            self._take_edge(edge)
        if came.lost:
            self._lost += 1
            at = now_us()
            self._deliver(self._levels(), at)

    def _take_edge(self, edge: LineEdge) -> None:
        self._edges += 1
        self._count[edge.line] += 1
        if self._count[edge.line] > MOST_EDGES:
            self._noisy = edge.line
            return
        self._deliver(self._values(edge.line, edge.high), min(edge.at, now_us()))

    def _values(self, line: str, high: bool) -> dict[str, Value]:
        return {name: channel.value(high) for name, channel in self._by_line.get(line, {}).items()}

    def _deliver(self, values: dict[str, Value], at: int) -> None:
        if not values or self._closed:
            return
        self._frames += 1
        self._last_frame = at
        self._call(self._on_frame, Frame(at, None, None, values))

    def _claim(self) -> None:
        self._lines.request(self._inputs)
        self._open = True
        self._opened += 1
        self._lines_error = ""
        self._backoff.worked()

    def _fail(self, error: Exception) -> None:
        self._release()
        self._backoff.failed()
        if isinstance(error, ReportedError):
            self._lines_error = str(error)
        else:
            self._lines_error = f"the input lines cannot be read: {named(error)}."
        self._judge()

    def _release(self) -> None:
        self._open = False
        with suppress(Exception):  # what has gone cannot be given back
            self._lines.close()

    def _judge(self) -> None:
        """Report a change of the errors."""
        error = " ".join(filter(None, (self._lines_error, self._noise_error, *self._analog.errors.values())))
        if error == self._error:
            return
        self._error, self._since = error, now_us()
        if self._on_change and not self._closed:
            self._call(self._on_change, self.health)

    def _call(self, callback: Callable[..., None], argument: object) -> None:
        try:
            callback(argument)
        except BaseException:  # noqa: BLE001 a callback may raise anything; the next frame counts
            _log.exception("a listener of the inputs failed")


def _noise(line: str, period_us: int) -> str:
    return (
        f"The input line {line} changes more than {MOST_EDGES} times in {period_us / 1000:g} ms and is read with this "
        "period only. Is a wire loose? debounce_ms keeps short changes away."
    )


def lines_of(description: Description, reader: str = "inputs") -> InputLines:
    """Return the input lines of a tool for one of its two readers: the sensor reader or the line arbiter."""
    if description.lines.backend == "virtual":
        return VirtualInputLines(description.lines.path or "", reader=reader)
    return GpiodInputLines(outputs=description.wired_lines)
