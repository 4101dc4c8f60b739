"""How a process of nodes ends: once, in bounded time, and with one sentence for an error."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue

from end_effector_hal.errors import ReportedError

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
