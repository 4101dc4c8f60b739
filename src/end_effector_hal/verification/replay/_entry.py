"""A record of a run, from any file."""

from __future__ import annotations

from typing import Any, NamedTuple


class Entry(NamedTuple):
    """A record, at its place in the order of all records.

    Attributes:
        at: time, µs on the monotonic clock.
        kind: a key of `end_effector_hal.runtime.boundary.KINDS`.
        record: the typed record; None: the rest of its trace cannot be read.
    """

    at: int
    kind: str
    record: Any
