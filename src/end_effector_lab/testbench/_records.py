"""Files that a testbench writes: events for benchmarks, and the real sensor values."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Value
from end_effector_hal.wires.lines import Edge


class TextFile:
    """A text file that is flushed after every line: a kill loses at most the last line.

    Args:
        path: path of the file; an existing file is replaced.

    Raises:
        UsageError: the file cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = path
        try:
            self._file = Path(path).open("w", encoding="utf-8", buffering=1)  # noqa: SIM115 close() ends it
        except OSError as error:
            raise self._error(error) from error

    def write(self, line: str) -> None:
        """Write a line; raises UsageError if the disk is full."""
        try:
            self._file.write(line + "\n")
        except OSError as error:
            raise self._error(error) from error

    def close(self) -> None:
        with suppress(OSError):  # said already
            self._file.close()

    def _error(self, error: OSError) -> UsageError:
        return UsageError(
            f"it cannot be written: {error.strerror}.", where=str(self._path), todo="Give another path."
        )


class Events(TextFile):
    """JSON lines: ``{"at", "seen", "line", "level"}`` for an edge, ``{"at", "frame", "sent", "values"}`` for a frame.

    ``at`` is monotonic µs: for an edge the time of its writer (``seen``: the time in the testbench), for a frame its
    last byte.
    """

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        self._entry(at=at, seen=seen, line=name, level=int(level))

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        self._entry(at=at, frame=seq, sent=sent, values=dict(values))

    def _entry(self, **fields: object) -> None:
        self.write(json.dumps(fields, separators=(",", ":")))


def edges_of(path: str | Path) -> list[Edge]:
    """Return the edges in a file of `Events`."""
    with Path(path).open(encoding="utf-8") as file:
        entries = [json.loads(line) for line in file if line.endswith("\n")]
    return [
        Edge(each["at"], each["line"], "out", bool(each["level"]), 0) for each in entries if "line" in each
    ]


class Record(TextFile):
    """CSV of the real values of all sensors, frame by frame, including silent or disturbed links.

    ``time_s`` since the start, then a column per channel: gauge kPa, or 0 and 1; empty: marked as invalid.
    """

    _start: int | None = None

    def frame(self, at: int, values: Mapping[str, Value]) -> None:
        if self._start is None:
            self._start = at
            self.write(",".join(["time_s", *values]))
        self.write(",".join([f"{(at - self._start) / 1e6:.6f}", *map(_cell, values.values())]))


def _cell(value: Value) -> str:
    if value is None:
        return ""
    return str(int(value)) if isinstance(value, bool) else f"{value / 1000:.3f}"
