"""A record of a run, whichever file or program it comes from."""

from __future__ import annotations

from typing import Any, NamedTuple


class Entry(NamedTuple):
    """One record of a program, at its place in the order of all.

    Attributes:
        at: µs on the monotonic clock.
        program: `grip` or `tool_change`.
        kind: of `end_effector_hal.runtime.boundary.KINDS`.
        record: typed; None: its trace cannot be read on.
    """

    at: int
    program: str
    kind: str
    record: Any
