"""A process of nodes: its log, its callbacks, and its end in bounded time, with one sentence for an error.

ROS writes to files, to a terminal and to /rosout in the thread that logs: a line must not delay the message of a
status. So the log is written in a thread of its own, at a limited rate.
"""

from __future__ import annotations

import ctypes
import faulthandler
import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue

from end_effector_hal.errors import ReportedError
from end_effector_hal.vocabulary import printable
from end_effector_hal.wires import now_us, tune_interpreter

BURST, PER_S = 50, 5.0
"""Maximum number of lines at once, and per second in the long run; counted separately for INFO and for
higher levels.
"""
LONGEST = 10_000
"""Maximum length of a line, characters."""
FLUSH_S = 1.0

_Line = Callable[[], None]


class Allowance:
    """The number of lines that may be written now; refused lines are counted until the next one that may.

    Args:
        clock: returns the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._left, self._at = clock, float(BURST), clock()
        self._refused = 0

    def use(self) -> int | None:
        """Use one line, and return how many were refused since the last one; None: there is none left."""
        now = self._clock()
        self._left, self._at = min(float(BURST), self._left + (now - self._at) * PER_S), now
        if self._left < 1.0:
            self._refused += 1
            return None
        self._left -= 1.0
        refused, self._refused = self._refused, 0
        return refused


class PacedLog(logging.Handler):
    """Passes records to a writer, in their order.

    Args:
        write: writes a text at a level of `logging`; it may wait.
    """

    def __init__(self, write: Callable[[int, str], None]) -> None:
        super().__init__()
        self._write = write
        self._common, self._worse = Allowance(), Allowance()
        self._lines: SimpleQueue[_Line | None] = SimpleQueue()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:  # called under the handler's lock
        """Queue a record for the writer; never waits before :meth:`end`."""
        refused = (self._common if record.levelno <= logging.INFO else self._worse).use()
        if refused is None:
            return
        if refused:
            left_out = f"{refused} lines were left out: there were more than {PER_S:g} a second."
            self._put(lambda: self._write(logging.WARNING, left_out))
        text = "\n".join(printable(line, LONGEST) for line in self.format(record)[:LONGEST].splitlines())
        self._put(lambda: self._write(record.levelno, text))

    def end(self) -> None:
        """Write the waiting lines, for a second at most; a later record is written in the thread that logs it."""
        self.acquire()
        self._ended = True
        self.release()
        self._lines.put(None)
        self._thread.join(FLUSH_S)

    def _put(self, line: _Line) -> None:
        if not self._ended:
            self._lines.put(line)
            return
        self._thread.join(FLUSH_S)
        line()

    def _run(self) -> None:
        while line := self._lines.get():
            line()


def node_log(node: str, write: Callable[[int, str], None]) -> tuple[logging.Logger, PacedLog]:
    """Return the logger of a node, and its handler; other records of the package go to the first node of
    the process.
    """
    handler = PacedLog(write)
    top, log = logging.getLogger("end_effector_hal"), logging.getLogger(f"end_effector_hal.{node}")
    top.propagate = log.propagate = False
    top.setLevel(logging.INFO)
    top.handlers = top.handlers or [handler]
    log.handlers = [handler]
    return log, handler


class Starters:
    """Calls back once all nodes exist and memory is cleaned up, which takes so long that readings would
    become stale.
    """

    def __init__(self) -> None:
        self._callbacks: list[Callable[[], None]] = []

    def add(self, callback: Callable[[], None]) -> None:
        """Register a callback; they are called in the order of registration."""
        self._callbacks.append(callback)

    def start(self) -> None:
        """Tune the interpreter and call all callbacks: all nodes exist now."""
        tune_interpreter()
        for callback in self._callbacks:
            callback()


@dataclass(slots=True)
class _Tick:
    period_us: int
    callback: Callable[[], None]
    log: logging.Logger
    due_us: int


class Ticks:
    """Calls functions at steady rates, all in one thread, and those that are due together in one go: each wake-up costs
    more than a call. Calls that are missed during a pause of the machine are skipped; exceptions are logged.
    """

    def __init__(self) -> None:
        self._all: list[_Tick] = []
        self._begun_us, self._changed, self._closed = now_us(), threading.Event(), False

    def add(self, rate_hz: float, callback: Callable[[], None], log: logging.Logger) -> None:
        """Call ``callback`` at a rate from now on; the first one that is added starts the thread."""
        period_us = round(1e6 / rate_hz)
        self._all.append(_Tick(period_us, callback, log, self._next_us(period_us, now_us())))
        self._changed.set()
        if len(self._all) == 1:
            threading.Thread(target=self._run, name="ticks", daemon=True).start()

    def close(self) -> None:
        """Stop: no more calls begin."""
        self._closed = True
        self._changed.set()

    def call(self, at: int) -> int:
        """Call what is due at ``at`` (µs), and return when the next call is due."""
        for tick in tuple(self._all):
            if tick.due_us <= at and not self._closed:
                tick.due_us = self._next_us(tick.period_us, at)
                try:
                    tick.callback()
                except Exception:
                    tick.log.exception("a periodic task failed")
        return min(tick.due_us for tick in self._all)

    def _run(self) -> None:
        while not self._closed:
            due_us = self.call(now_us())
            self._changed.wait(max(0, due_us - now_us()) / 1e6)
            self._changed.clear()

    def _next_us(self, period_us: int, at: int) -> int:
        """Return the next multiple of a period since the beginning, so that several of them coincide."""
        return at + period_us - (at - self._begun_us) % period_us


SIGEV_THREAD = 2


class _SigEvent(ctypes.Structure):
    """The structure ``sigevent`` of timer_create(2)."""

    _fields_ = (
        ("value", ctypes.c_void_p),
        ("signo", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("reserved", ctypes.c_char * 32),
    )


class _Spec(ctypes.Structure):
    """The structure ``itimerspec`` of timer_settime(2): seconds and nanoseconds; the timer fires once."""

    _fields_ = tuple((name, ctypes.c_long) for name in ("interval_s", "interval_ns", "value_s", "value_ns"))


def leave_within(seconds: int, code: int) -> None:
    """Leave the process with an exit code after ``seconds``, if it has not ended by itself.

    The C library does it, in a thread of its own: a library that hangs may keep the interpreter's lock.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    if not hasattr(libc, "timer_create"):  # before glibc 2.34: then nothing bounds it
        return
    event = _SigEvent(
        value=code, notify=SIGEV_THREAD, function=ctypes.cast(libc._exit, ctypes.c_void_p).value
    )
    timer = ctypes.c_void_p()
    made = libc.timer_create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer))
    if made == 0:
        libc.timer_settime(timer, 0, ctypes.byref(_Spec(value_s=seconds)), None)


LOOK_S = 0.5
STDERR = 2
LONGEST_S = 20.0
"""Longest time that the end takes for any reason, s; then the process is left by force, and prints where it hangs."""


class ProcessEnd:
    """Ends a process; thread-safe, and safe in a signal handler.

    Args:
        longest_s: time for an end in good order, s; after an error the process is left by force when this time is
            over.
    """

    def __init__(self, longest_s: float) -> None:
        self._longest_s = longest_s
        self._failed: ReportedError | None = None
        self._begun = self._bounded = False
        # no Event: its lock may be held by the very thread in which a signal handler runs
        self._wake: SimpleQueue[None] = SimpleQueue()

    @property
    def begun(self) -> bool:
        """Whether the process is to end."""
        return self._begun

    @property
    def exit_code(self) -> int:
        """Exit code of the process, as far as it is known now."""
        return self._failed.exit_code if self._failed else 0

    def begin(self) -> None:
        """Begin the end of the process; a second call does no harm."""
        self.bound()
        self._begun = True
        self._wake.put(None)

    def fail(self, error: ReportedError) -> bool:
        """End with an error, so that the launcher restarts this process; return False if it has failed before."""
        if self._failed is not None:
            return False
        self._failed = error
        with suppress(RuntimeError):  # no thread
            threading.Thread(target=self._leave_by_force, args=(error,), daemon=True).start()
        return True

    def wait(self) -> int:
        """Wait for the end, in one thread, and return the exit code; raises the error that :meth:`fail` got."""
        while not self._begun:
            with suppress(Empty):  # a signal may reach another thread: its handler runs when this one looks
                self._wake.get(timeout=LOOK_S)
        if self._failed is not None:
            raise self._failed
        return 0

    def bound(self) -> None:
        """Start the limit of `LONGEST_S`: after it the process is left by force, and prints where it hangs."""
        if not self._bounded:
            self._bounded = True
            # no thread of Python: what hangs may hold its lock, or be its end
            faulthandler.dump_traceback_later(LONGEST_S, exit=True, file=STDERR)

    def _leave_by_force(self, error: ReportedError) -> None:
        time.sleep(self._longest_s)
        os._exit(error.exit_code)


def guarded(name: str, body: Callable[[], int | None]) -> int:
    """Call ``body`` and return the exit code; an error is printed as one sentence after ``name``."""
    try:
        return int(body() or 0)
    except ReportedError as error:
        print(f"{name}: {error}", file=sys.stderr)  # noqa: T201 there is no logger before a node is up
        return error.exit_code
    except KeyboardInterrupt:
        return 130
