"""The clock that all processes of a machine share, waiting times, and the tuning of the interpreter."""

from __future__ import annotations

import ctypes
import gc
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from end_effector_hal.errors import WireError


def now_us() -> int:
    """Return CLOCK_MONOTONIC in µs; all processes of one machine share this clock."""
    return time.monotonic_ns() // 1000


SWITCH_S = 0.0005
"""Time after which a computing thread yields to a waiting one, s; Python's default is ten times as long."""
COLLECT_AFTER = 10_000
"""Number of new objects before a garbage collection; objects of a reaction are freed without one, and cycles are rare.
"""


def tune_interpreter() -> None:
    """Tune Python for short reaction times; call this after all objects are built.

    The garbage collector no longer scans the existing objects, which would take milliseconds each time. Memory that
    was only needed to build them (the trees of two parsers) is returned to the system.
    """
    sys.setswitchinterval(SWITCH_S)
    gc.unfreeze()  # objects that a call before this one has frozen
    gc.collect()
    with suppress(OSError, AttributeError):  # only glibc has it
        ctypes.CDLL(None).malloc_trim(0)
    gc.freeze()
    gc.set_threshold(COLLECT_AFTER, 20, 20)


CPU_LATENCY = Path("/dev/cpu_dma_latency")
"""The kernel's power management keeps the processors as awake as the open file requires (PM QoS)."""


@contextmanager
def processors_awake(device: Path = CPU_LATENCY) -> Iterator[None]:
    """Keep the processors of the machine out of deep sleep, from which they need up to a millisecond to wake.

    Raises:
        WireError: the device cannot be opened.
    """
    try:
        request = device.open("wb", buffering=0)
    except OSError as error:
        raise WireError(
            f"{device}: {error.strerror}.",
            todo="Give this user access to it (docs/how-to/deployment.md), or leave out --keep-awake.",
        ) from error
    with request:
        request.write(bytes(4))  # 0 µs, for as long as the file is open
        yield


FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 5.0


class Backoff:
    """Waits 0.1 s after a failure, doubling with each further one up to 5 s.

    Args:
        clock: µs.
    """

    def __init__(self, clock: Callable[[], int] = now_us) -> None:
        self._clock = clock
        self._next = 0
        self._wait_s = FIRST_WAIT_S

    def is_due(self) -> bool:
        """Return whether the next try may be made now."""
        return self._clock() >= self._next

    def failed(self) -> None:
        """Start the next wait, twice as long as the last one."""
        self._next = self._clock() + round(self._wait_s * 1e6)
        self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def worked(self) -> None:
        """Reset the waiting time after a success."""
        self._next, self._wait_s = 0, FIRST_WAIT_S
