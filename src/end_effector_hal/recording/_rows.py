"""A CSV file that is written row by row, and read back line by line."""

from __future__ import annotations

import os
import re
import threading
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from end_effector_hal._closing import Closing
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.owned import open_owned

from ._files import RecordingLimits, append_whole, lock, make_room, numbered_files, read_file, still_there

Row = TypeVar("Row")
LONGEST_S = 1e9
_TAIL = 65536
_NUMBER = re.compile(r"[+-]?(\d{1,15}(\.\d{0,12})?|\.\d{1,12})([eE][+-]?\d{1,2})?", re.ASCII)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,79}", re.ASCII)


class RowFile:
    """A file of rows, each passed to the kernel in one write: a kill of the process loses at most the last row.

    An existing file with the same header is continued; a truncated last line is removed first. Only one process can
    write at a time; it holds a lock until it ends.

    Args:
        path: path of the file.
        columns: names for its header.
        limits: a file that has reached the limit is renamed ``NAME-1.csv``, ``NAME-2.csv``, …, and the next one begins
            under the same name; None: no limit.
        opening: returns the first rows of the next file, so that it can be read without the previous one.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        limits: RecordingLimits | None = None,
        opening: Callable[[], str] = str,
    ) -> None:
        self.path = Path(path)
        self._limits, self._opening = limits, opening
        self._header = ",".join(checked_names(columns)) + "\n"
        try:
            self._fd = open_owned(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise UsageError(f"Cannot be written: {error.strerror}.", where=str(self.path)) from None
        self.last: tuple[str, ...] | None = None
        try:
            if not lock(self._fd):
                raise UsageError(
                    "Another program is writing this file.",
                    where=str(self.path),
                    todo="Stop it, or choose another name.",
                )
            self._resume()
        except OSError as error:
            self.close()
            raise UsageError(f"Cannot be written: {error.strerror}.", where=str(self.path)) from None
        except BaseException:
            self.close()
            raise

    def _resume(self) -> None:
        size = os.fstat(self._fd).st_size
        head = os.pread(self._fd, len(self._header), 0).decode(errors="replace")
        if size < len(self._header) and self._header.startswith(head):
            os.ftruncate(self._fd, 0)
            append_whole(self._fd, self._header.encode())
            return
        if head != self._header:
            found = head.splitlines()[0] if head.strip() else ""
            raise UsageError(
                f"This file has another header ({found[:60]!r}, not {self._header.strip()!r}).",
                where=f"{self.path}:1",
                todo="Choose another name.",
            )
        start = max(0, size - _TAIL)
        tail = os.pread(self._fd, _TAIL, start)
        complete = tail.rfind(b"\n") + 1
        os.ftruncate(self._fd, start + complete)
        lines = tail[:complete].decode(errors="replace").splitlines()
        if start + complete > len(self._header) and lines:
            self.last = tuple(lines[-1].split(","))

    def append(self, text: str) -> None:
        """Append one or more whole rows, each with its line end; raises ReportedError when they cannot be written."""
        if self._fd < 0:
            raise UsageError("This file is closed.", where=str(self.path))
        data = text.encode()
        try:
            still_there(self.path, self._fd)
            size = os.fstat(self._fd).st_size
            if self._limits is not None and size + len(data) > self._limits.segment_bytes:
                self._begin_segment(self._limits)
            append_whole(self._fd, data)
        except OSError as error:
            what = f"A row could not be written: {error.strerror}."
            raise ReportedError(what, where=str(self.path)) from None

    def _begin_segment(self, limits: RecordingLimits) -> None:
        """Rename the file with a number, and begin the next file; after an OSError nothing has changed."""
        make_room(self.path.parent, limits)
        fresh = self.path.with_name(f".{self.path.name}.next")
        fd = open_owned(fresh, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
        try:
            lock(fd)
            append_whole(fd, (self._header + self._opening()).encode())
            numbers = [number for number, _ in numbered_files(self.path)]
            self.path.rename(self.path.with_stem(f"{self.path.stem}-{max(numbers, default=0) + 1}"))
            fresh.rename(self.path)
        except BaseException:
            os.close(fd)
            with suppress(OSError):
                fresh.unlink()
            raise
        os.close(self._fd)
        self._fd = fd

    def close(self) -> None:
        """Close the file; may be called again."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


@dataclass(frozen=True)
class Line:
    """One line of a file that is being read."""

    path: str
    number: int
    text: str
    complete: bool

    @property
    def where(self) -> str:
        """The place as ``file:line``."""
        return f"{self.path}:{self.number}"

    @property
    def cut_off(self) -> str:
        """A note about this line, which lacks its end."""
        return f"{self.where}: the last line is cut off and was dropped."

    def fault(self, what: str, todo: str = "") -> UsageError:
        """Return the error to raise about this line."""
        return UsageError(what, where=self.where, todo=todo)

    def fields(self, columns: Sequence[str]) -> list[str]:
        """Return the fields of the line; their number must equal the number of columns."""
        fields = [field.strip() for field in self.text.split(",")]
        if len(fields) != len(columns):
            raise self.fault(f"This row has {len(fields)} fields, the header names {len(columns)}.")
        return fields

    def seconds(self, text: str, earliest_s: float) -> float:
        """Return a time since start; it must not be earlier than ``earliest_s``."""
        value = self.number_of(text, "time_s")
        if not 0 <= value <= LONGEST_S:
            raise self.fault(f"time_s is {text[:40]}, expected are seconds since the start, from 0 on.")
        if value < earliest_s:
            raise self.fault(f"Time runs backwards: {value:.6f} s follows {earliest_s:.6f} s.")
        return value

    def number_of(self, text: str, column: str) -> float:
        """Return a finite number."""
        if not _NUMBER.fullmatch(text):
            raise self.fault(f"{column} is {text[:40]!r}, expected is a number.")
        return float(text)


class TableWriter(Closing, Generic[Row]):
    """The base class of the writers of all tables; see `RowFile` for the arguments and the errors.

    Each segment of a table begins with the last row of the one before it.
    """

    _last: Row | None = None

    def __init__(
        self, path: str | Path, columns: Sequence[str], limits: RecordingLimits | None = None
    ) -> None:
        self._file, self._lock = RowFile(path, columns, limits, self._opening), threading.Lock()

    @abstractmethod
    def _text(self, row: Row) -> str:
        """Return a row with its line end."""

    def _opening(self) -> str:
        """Return the rows with which the next segment begins."""
        return self._text(self._last) if self._last is not None else ""

    def _resumed(self, read: Callable[[Line], Row]) -> Row | None:
        """Return the last row of the file, also if an earlier process wrote it."""
        if self._file.last is None:
            return None
        where = str(self._file.path)
        try:
            return read(Line(where, 0, ",".join(self._file.last), complete=True))
        except UsageError:
            self._file.close()
            raise UsageError(
                "The last row cannot be read.", where=where, todo="Choose another name."
            ) from None

    def _check_time(self, time_s: float) -> None:
        if not 0 <= time_s <= LONGEST_S:
            raise UsageError(
                f"{time_s} is not a time since the start in seconds.", where=str(self._file.path)
            )

    def close(self) -> None:
        """Close the file; may be called again."""
        self._file.close()


def read_lines(path: str | Path) -> Iterator[Line]:
    """Yield the non-blank lines of a file, after those of its earlier segments; the header comes only once.

    Raises:
        UsageError: a file cannot be read, or has another header than the first.
    """
    header, files = "", [older for _, older in numbered_files(path)]
    if not files or Path(path).exists():  # a kill may leave closed segments alone
        files.append(Path(path))
    for each in files:
        for line in _lines_of(each):
            if line.number == 1 and header:
                if line.text != header:
                    raise line.fault(
                        f"The header is {line.text[:60]!r}, that of the segment before is {header[:60]!r}."
                    )
                continue
            header = header or line.text
            yield line


def _lines_of(path: str | Path) -> Iterator[Line]:
    try:
        data = read_file(path)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise UsageError(f"Cannot be read: {reason}.", where=str(path)) from None
    lines = data.decode("utf-8-sig", errors="replace").split("\n")
    for number, text in enumerate(lines, start=1):
        if text.strip():
            yield Line(str(path), number, text.removesuffix("\r"), number < len(lines))


def read_header(lines: Iterator[Line], path: str | Path, fixed: Sequence[str]) -> tuple[str, ...]:
    """Return the column names that follow the fixed ones in the header."""
    expected = ",".join(fixed) + ",…"
    first = next(lines, None)
    if first is None:
        raise UsageError(f"This file is empty, expected is a header {expected!r}.", where=f"{path}:1")
    names = [name.strip() for name in first.text.split(",")]
    if not first.complete or first.number != 1 or names[: len(fixed)] != list(fixed):
        raise first.fault(f"The header is {first.text[:60]!r}, expected is {expected!r}.")
    try:
        return tuple(checked_names(names)[len(fixed) :])
    except UsageError as error:
        raise first.fault(error.what) from None


def read_rows(
    lines: Iterator[Line], read: Callable[[Line, float], Row], time_of: Callable[[Row], float]
) -> tuple[list[Row], str]:
    """Return the rows of the complete lines, and a note about the last one if it is cut off.

    A segment begins with the last row of the one before it, which is left out here.

    ``read``: reads a row from its line and the earliest time that it may have, s.
    """
    rows: list[Row] = []
    for line in lines:
        if not line.complete:
            return rows, line.cut_off
        row = read(line, time_of(rows[-1]) if rows else 0.0)
        if not rows or row != rows[-1]:
            rows.append(row)
    return rows, ""


def checked_names(names: Sequence[str]) -> Sequence[str]:
    """Check that every column name is valid and unique; return the names."""
    for name in names:
        if not _NAME.fullmatch(name):
            raise UsageError(f"{name[:40]!r} cannot be the name of a column.")
        if list(names).count(name) > 1:
            raise UsageError(f"The column {name!r} is given twice.")
    return names
