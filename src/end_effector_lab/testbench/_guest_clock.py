"""The clock of an emulated machine, which may be slower than ours."""

from __future__ import annotations

import threading
from collections.abc import Callable

COUNTER, HERTZ, BITS = 0x30370054, 32768, 32
"""Low word of the real-time counter of an i.MX 8M Plus (SNVS); with ``-rtc clock=vm`` it counts the machine's time."""
LEAST_S, MOST_S = 0.001, 0.1


class GuestClock:
    """Reads a counter of the machine.

    A machine that counts instructions (``-icount``) has a time of its own: it stands still while this machine has no
    time for it, and is never ahead of ours while it rests. Who waits for it asks again and again.

    Args:
        ask: gives QEMU a command of qtest; "": it has ended, and its clock stands still.
    """

    def __init__(self, ask: Callable[[str], str]) -> None:
        self._ask = ask
        self._lock = threading.Lock()
        self._last: int | None = None
        self._ticks = 0

    def now_us(self) -> int:
        """Since it was asked first."""
        with self._lock:
            count = self._count()
            if count is not None and self._last is not None:
                self._ticks += (count - self._last) % (1 << BITS)
            self._last = self._last if count is None else count
            return self._ticks * 1_000_000 // HERTZ

    def wait(self, stop: threading.Event, until: int) -> bool:
        while (left := until - self.now_us()) > 0:
            if stop.wait(min(max(left / 1e6, LEAST_S), MOST_S)):
                return True
        return stop.is_set()

    def _count(self) -> int | None:
        match self._ask(f"readl {COUNTER:#x}").split():
            case ["OK", number]:
                return int(number, 16)
        return None
