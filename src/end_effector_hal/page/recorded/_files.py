"""The traces of a recording: which traces belong together, and their records in order of time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.runtime.boundary import Header
from end_effector_hal.verification.replay import Entry, ProgramTrace, load_trace, traces_of

MOST_BYTES = 512_000_000
"""Largest trace that is read, bytes, since it is read whole; a segment has 64 MB unless configured otherwise."""


KEPT_BYTES = 100_000_000
TOLD = "told"
"""Kind of an entry that is in no trace: changes of variables, for the log of the page."""


@dataclass(frozen=True, slots=True)
class _Part:
    path: Path
    header: Header
    last_at: int
    complete: bool


class RecordingFiles:
    """The traces of a folder, or one trace; read once to inspect them, and again when their records are needed.

    Args:
        path: a folder with traces, or one trace.
        description: a tool to use instead of the recorded one; None: the recorded one, which the trace contains.

    Raises:
        UsageError: there is no readable trace, or its description is not valid any more.

    Attributes:
        name: name of the folder or the file.
        notes: sentences about unreadable, omitted and truncated traces.
        header: header of the first trace.
        description: the tool as it was recorded.
        begin, end: time of the first and of the last record, µs.
        has_events: always true; a table of events may be missing (`RecordedTables`).
        whole: whether every trace was closed normally, and none was left out.
    """

    def __init__(self, path: Path, description: Description | None = None) -> None:
        self.path, self.name = path, path.resolve().name
        self.notes: list[str] = []
        self.paths = traces_of(path)
        self.stamp = stamp_of(path)
        self._kept: dict[Path, ProgramTrace] = {}
        parts: list[_Part] = []
        first: ProgramTrace | None = None
        refused: UsageError | None = None
        for each in self.paths:
            try:
                trace = self.load(each)
                last_at = trace.last_at
            except UsageError as error:
                refused = refused or error
                self.notes.append(f"Left out: {each.name}. {error.what}")
                continue
            if why := self._foreign(trace, first, parts):
                self.notes.append(f"Left out: {each.name}, {why}")
                continue
            first = first or trace
            if trace.file.note:
                state = "damaged" if trace.file.damaged else "not whole"
                self.notes.append(
                    f"{each.name} is {state}: {trace.file.note}. What was written before is shown."
                )
            if trace.header.gap is not None:
                gap = trace.header.gap
                self.notes.append(f"Before {each.name} {gap.records} records were not written: {gap.why}.")
            parts.append(_Part(each, trace.header, last_at, trace.file.complete and not trace.file.damaged))
        if first is None:
            assert refused is not None
            raise refused
        self.description: Description = description or first.description()
        self.header = first.header
        if description is not None and (own := content_hash(description)) != first.header.hash:
            self.notes.append(
                f"It is shown with another description ({own}) than recorded ({first.header.hash})."
            )
        self._given = description
        self._parts = parts
        self.begin = min(part.header.at for part in parts)
        self.end = max(self.begin, *(part.last_at for part in parts))
        self.has_events = True
        self.whole = not refused and all(part.complete for part in parts)

    def again(self) -> RecordingFiles:
        """Return the recording as it is on disk now."""
        return RecordingFiles(self.path, self._given)

    def load(self, path: Path) -> ProgramTrace:
        """Load one of the traces; a few are cached because they are read several times.

        Raises:
            UsageError: the trace cannot be read.
        """
        if path not in self._kept:
            trace = _load(path)
            if sum(each.file.size for each in self._kept.values()) + trace.file.size > KEPT_BYTES:
                return trace
            self._kept[path] = trace
        return self._kept[path]

    def known(self, view: dict[str, Any]) -> dict[str, Any]:
        """Return the view without values that were not recorded: unchanged, as a trace records everything."""
        return view

    @property
    def grown(self) -> bool:
        """Whether the files have changed since they were read."""
        return stamp_of(self.path) != self.stamp

    def entries(self) -> Iterator[Entry]:
        """Yield all records in the order of writing; an unreadable record is noted and ends its file."""
        at = self.begin
        for part in self._parts:
            try:
                trace = self.load(part.path)
                for number, record in enumerate(trace.file.records):
                    typed = trace.typed(number)
                    at = max(at, typed.at)
                    yield Entry(at, record.kind, typed)
            except ReportedError as error:
                self.notes.append(f"{part.path.name}: {_what(error)} What follows in this file is not shown.")
                self.whole = False
                yield Entry(at, "unreadable", None)

    def _foreign(self, trace: ProgramTrace, first: ProgramTrace | None, parts: list[_Part]) -> str:
        """Return why a trace does not belong to the first one; empty if it does."""
        if first is None:
            return ""
        if trace.header.hash != first.header.hash:
            return (
                f"which is of another description ({trace.header.description}, {trace.header.hash}) than the first "
                f"trace ({first.header.description}, {first.header.hash}). Open it by its own name."
            )
        if trace.header.at < parts[-1].header.at:
            return "which was recorded after a restart of the machine. Open it by its own name."
        return ""


def stamp_of(path: Path) -> tuple[tuple[str, int, int], ...]:
    """Return names, sizes and times of a recording's traces; they change when the recording grows."""
    try:
        return tuple((each.name, each.stat().st_size, each.stat().st_mtime_ns) for each in traces_of(path))
    except (UsageError, OSError):
        return ()


def _what(error: ReportedError) -> str:
    """Return an error's text without the file's path, since the page may be viewed on another machine."""
    return error.what if isinstance(error, UsageError) else str(error)


def _load(path: Path) -> ProgramTrace:
    with os_errors("Cannot be read", path):
        size = path.stat().st_size
    if size > MOST_BYTES:
        what = f"This trace has {size / 1e6:.0f} MB; at most {MOST_BYTES / 1e6:.0f} MB are read."
        raise UsageError(what, where=str(path), todo="Record in segments: --segment-mb.")
    return load_trace(path)
