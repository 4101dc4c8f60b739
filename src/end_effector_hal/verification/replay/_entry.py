"""A record of a run, from any file and program."""

from __future__ import annotations

from typing import Any, NamedTuple


class Entry(NamedTuple):
    """A record of a program, at its place in the order of all records.

    Attributes:
        at: time, µs on the monotonic clock.
        program: `grip` or `tool_change`.
        kind: a key of `end_effector_hal.runtime.boundary.KINDS`.
        record: the typed record; None: the rest of its trace cannot be read.
    """

    at: int
    program: str
    kind: str
    record: Any
