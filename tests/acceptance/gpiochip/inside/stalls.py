"""In the guest: tells when it stood still. A line for each: until when, for how long; µs of its monotonic clock."""

from __future__ import annotations

import time

PERIOD_US = 20_000
STALL_US = 80_000


def now_us() -> int:
    return time.monotonic_ns() // 1000


before = now_us()
while True:
    time.sleep(PERIOD_US / 1e6)
    now = now_us()
    if now - before - PERIOD_US > STALL_US:
        print(now, now - before - PERIOD_US, flush=True)  # noqa: T201 its purpose
    before = now
