"""Read a trace with typed records."""

from __future__ import annotations

import atexit
import os
import re
import shutil
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.control import network_of
from end_effector_hal.description import Description, load
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.recording import Record, TraceFile, read_trace
from end_effector_hal.runtime.boundary import DESCRIPTION, KINDS, MODEL, Header


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


SUFFIX = ".mcap"
FARTHEST_US = 2**63 - 1
"""Largest time that a clock can show, µs."""


@dataclass(frozen=True, slots=True)
class ProgramTrace:
    """A trace: its file, its header, and its records in order."""

    file: TraceFile
    header: Header

    def typed(self, number: int) -> Any:
        """Return a record as its dataclass; raises UsageError when it is invalid."""
        record = self.file.records[number]
        try:
            typed = _adapter(record.kind).validate_json(record.data)
        except ValidationError as error:
            raise self._fault(number, record, error) from None
        if abs(getattr(typed, "at", 0)) > FARTHEST_US:
            raise self._fault(number, record, ValueError("at: it is no time"))
        return typed

    def content(self, number: int) -> dict[str, Any]:
        """Return a record as JSON, with its time ``at``; raises UsageError when it is invalid."""
        record = self.file.records[number]
        try:
            content = record.content
        except ValueError as error:
            raise self._fault(number, record, error) from None
        if type(content.get("at")) is not int or abs(content["at"]) > FARTHEST_US:
            raise self._fault(number, record, ValueError("at: it has no time"))
        return content

    @property
    def last_at(self) -> int:
        """The time of the last record, µs."""
        return max(int(self.content(n)["at"]) for n in range(len(self.file.records)))

    def seconds(self, at: int) -> float:
        """Convert a time to seconds since the beginning of the trace."""
        return (at - self.header.at) / 1_000_000

    def description(self) -> Description:
        """Return the recorded tool with its automata; its files exist until this process ends.

        Raises:
            UsageError: the trace does not contain it.
        """
        files = self.file.attachments
        if DESCRIPTION not in files or MODEL not in files:
            todo = "Name one with --description."
            raise UsageError(
                "This trace does not hold its description.", where=str(self.file.path), todo=todo
            )
        try:
            description = _unpacked(files[DESCRIPTION], files[MODEL])
            network_of(description)  # it is kept, and asked for next
        except ReportedError as error:
            raise UsageError(
                f"{self._doubt} {re.sub(r'^[^:]*/', '', str(error).splitlines()[0])}",
                where=str(self.file.path),
                todo="Name another with --description.",
            ) from None
        return description

    @property
    def _doubt(self) -> str:
        """A clause why the description in a trace, or its UPPAAL file, is unreadable; it was valid when it was
        written.
        """
        if self.file.damaged:
            return f"The trace is damaged ({self.file.note}), and with it the description in it:"
        if self.file.complete:
            return "This version no longer accepts the description in this trace:"
        return (
            "Bytes of the description in this trace were changed, or this version does not accept it "
            "(the trace was not closed, so it has no checksum):"
        )

    def _fault(self, number: int, record: Record, error: Exception) -> UsageError:
        what = f"Record {number} ({record.kind}) cannot be read: {_short(error)}."
        return UsageError(what, where=str(self.file.path))


def load_trace(path: str | Path) -> ProgramTrace:
    """Read a trace.

    Raises:
        UsageError: it cannot be read, or is no trace of this product.
    """
    file = read_trace(path)
    if not file.records and not file.complete:
        raise _without_header(file)
    if not file.records or file.records[0].kind != "header":
        todo = "Expected is a file that `eehal run --record` or a node wrote."
        raise UsageError("This MCAP file holds no header of a trace.", where=str(path), todo=todo)
    unknown = sorted({record.kind for record in file.records} - KINDS.keys())
    if unknown:
        raise UsageError(f"Records of an unknown kind: {', '.join(unknown)}.", where=str(path))
    try:
        header = TypeAdapter(Header).validate_json(file.records[0].data)
    except ValidationError as error:
        raise UsageError(f"The header cannot be read: {_short(error)}.", where=str(path)) from None
    return ProgramTrace(file, header)


def _without_header(file: TraceFile) -> UsageError:
    if file.damaged:
        what = f"Before its header the trace is damaged: {file.note}."
        return UsageError(what, where=str(file.path), todo="There is nothing to replay.")
    what = f"The trace ends after {file.size} bytes, before its header: there is nothing to replay."
    why = "The program was killed as it began, or the file was cut off."
    return UsageError(what, where=str(file.path), todo=why)


def traces_of(path: str | Path) -> tuple[Path, ...]:
    """Return the traces in a folder, or the named one, in the order of writing.

    Raises:
        UsageError: there is none, or the folder cannot be read.
    """
    path = Path(path)
    if path.suffix == SUFFIX and not path.is_dir():
        return (path,)
    found = tuple(sorted(_listed(path), key=_order)) if path.is_dir() else ()
    if not found:
        todo = "Name a folder that `eehal run --record` or `eehal demo` wrote, or a .mcap file in it."
        raise UsageError("There is no trace here.", where=str(path), todo=todo)
    return found


def runs_of(path: str | Path) -> tuple[Path, ...]:
    """Return the folders with traces below a folder, sorted by name; the folder itself, if it has traces.

    Links to other folders are not followed. An unreadable folder is included; `traces_of` then reports its error. A
    file is returned as it is. Raises UsageError when there is none.
    """
    path = Path(path)
    if not path.is_dir() or any(_listed(path)):
        traces_of(path)
        return (path,)
    unread: list[Path] = []
    walk = os.walk(path, onerror=lambda error: unread.append(Path(error.filename)))
    found = [Path(folder) for folder, _, names in walk if any(name.endswith(SUFFIX) for name in names)]
    return tuple(sorted(found + unread)) or traces_of(path)


def _listed(folder: Path) -> list[Path]:
    with os_errors("Cannot be read", folder):
        return [each for each in folder.iterdir() if each.name.endswith(SUFFIX)]


def _order(path: Path) -> tuple[str, int]:
    """Return a sort key by which ``hal-10.mcap`` comes after ``hal-9.mcap``."""
    name, _, number = path.stem.rpartition("-")
    return (name, int(number)) if name and number.isdecimal() and len(number) < 10 else (path.stem, 1)


@lru_cache(maxsize=8)
def _unpacked(description: bytes, model: bytes) -> Description:
    """Load a description from a trace; cached, so that its network is compiled once for all segments."""
    folder = Path(mkdtemp(prefix="eehal-replay-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / DESCRIPTION).write_bytes(description)
    (folder / MODEL).write_bytes(model)
    return load(folder / DESCRIPTION)


@cache
def _adapter(kind: str) -> TypeAdapter[Any]:
    return TypeAdapter(KINDS[kind])


def _short(error: Exception) -> str:
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        return f"{place}: {first['msg']}" if place else str(first["msg"])
    return str(error)
