"""A bound for the end of a process, for what not even a thread of Python can bound."""

from __future__ import annotations

import ctypes
import time

SIGEV_THREAD = 2


class _SigEvent(ctypes.Structure):
    """Of timer_create(2)."""

    _fields_ = (
        ("value", ctypes.c_void_p),
        ("signo", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("reserved", ctypes.c_char * 32),
    )


class _Spec(ctypes.Structure):
    """Of timer_settime(2): seconds and nanoseconds; it fires once."""

    _fields_ = tuple((name, ctypes.c_long) for name in ("interval_s", "interval_ns", "value_s", "value_ns"))


def leave_within(seconds: int, code: int) -> None:
    """Leave the process with an exit code after so many seconds, if it has not ended by itself.

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
