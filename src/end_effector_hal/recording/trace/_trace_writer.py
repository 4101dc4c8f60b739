"""A trace: the boundary record of a run, written to MCAP files as it happens, segment by segment."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, time_ns
from typing import NamedTuple

from end_effector_hal.errors import ReportedError
from end_effector_hal.recording._limits import MEGABYTE, RecordingLimits, make_room
from end_effector_hal.recording.trace._indexed import (
    TooLongError,
    remove_leftovers,
    start_indexing,
    write_indexed,
)
from end_effector_hal.recording.trace._segment import SegmentFile

_log = logging.getLogger("end_effector_hal.recording")
MOST_WAITING = 3_000
"""Records that wait for a disk that does not answer: what a program says in half a minute."""
RETRY_S = 1.0
"""After this a disk that failed is tried again."""
END_S = 2.0
"""So long the end of a program waits for its disk."""
INDEX_S = 1.5
"""So long the thread of the writer sorts a short segment, or the last one; the others get a process of their own."""
HEADER = "header"

Entry = tuple[str, int, object]
"""A record: its kind, its time and its content."""


@dataclass(frozen=True, slots=True)
class Gap:
    """What is missing before a segment.

    Attributes:
        since: µs, of the first record that was not written.
        records: how many were not written.
        why: in words.
    """

    since: int
    records: int
    why: str


class Opening(NamedTuple):
    """A segment is begun: what its header is made of.

    Attributes:
        at: µs on the monotonic clock.
        segment: its number since the start of the program, from 1 on.
        follows: the segment before it was closed in good order, and nothing is missing between the two.
        gap: what is missing before it; None: nothing.
    """

    at: int
    segment: int
    follows: bool
    gap: Gap | None


class _Begin(NamedTuple):
    at: int
    first: Sequence[Entry]
    gap: Gap | None


class TraceWriter:
    """Writes records in a thread of its own, each batch at once: what was written is there after a kill.

    `put` and `begin` never wait and never raise: recording does not stand in the way of a reaction. They
    belong to one thread at a time. Files are made, written and closed in the writer's thread only. While the disk
    fails nothing is recorded and :attr:`trouble` says so; it is tried again each second.

    The recorder checks :attr:`wants_state` after each batch: a file is long enough, or the disk works again.
    With `begin` the next segment starts, with what is needed to understand it without the one before.

    Args:
        folder: made if it is missing; files are named after the program: ``grip.mcap``, ``grip-2.mcap``, …
        program: whose trace it is; topics are ``program/kind``.
        kinds: name of each kind of record, and the dataclass of its content.
        now: µs on the monotonic clock of the run, now: the file carries the time of day, which fits other recordings.
        attachments: name and content of files that belong to the run; they are in each segment.
        header: makes the first record of a segment, of the kind ``header``; None: there is none.
        limits: of the folder.
        on_trouble: called when :attr:`trouble` has changed, in any thread; must not wait.
    """

    def __init__(
        self,
        folder: str | Path,
        program: str,
        kinds: Mapping[str, type],
        *,
        now: int,
        attachments: Mapping[str, bytes],
        header: Callable[[Opening], object] | None = None,
        limits: RecordingLimits | None = None,
        on_trouble: Callable[[], None] | None = None,
    ) -> None:
        self.on_trouble = on_trouble
        self.trouble = ""
        """Why nothing is recorded now, a sentence; empty: it is."""
        self.wants_state = False
        """The next segment can be begun."""
        self._folder, self._program, self._kinds, self._attachments = (
            Path(folder),
            program,
            kinds,
            attachments,
        )
        self._header, self._limits = header, limits or RecordingLimits()
        self._day_us = time_ns() // 1000 - now
        self._queue: queue.SimpleQueue[Sequence[Entry] | _Begin | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._queued = 0
        self._gap: Gap | None = None
        self._fresh: SegmentFile | None = None
        self._segment: SegmentFile | None = None
        self._number = 0
        self._full_at = 0
        self._ordered = True  # a segment that is not begun yet
        self._queue.put(_Begin(now, (), None))
        self._thread = threading.Thread(target=self._run, name=f"trace-{program}", daemon=True)
        self._thread.start()

    @property
    def path(self) -> Path | None:
        """Of the segment that is being written; None: there is none."""
        return self._segment.path if self._segment is not None else None

    def put(self, batch: Sequence[Entry]) -> None:
        """Have records written, times in µs on the monotonic clock; returns at once."""
        if not batch:
            return
        with self._lock:
            room = self._gap is None and self._queued + len(batch) <= MOST_WAITING
            self._queued += len(batch) if room else 0
        if room:
            self._queue.put(batch)
        else:
            self._lose(batch[0][1], len(batch), "the disk does not take the records in time")

    def begin(self, at: int, first: Sequence[Entry]) -> None:
        """Begin the next segment at ``at`` µs, with these records after its header; returns at once."""
        with self._lock:
            gap, self._gap = self._gap, None
            self.wants_state, self._ordered = False, True
        self._queue.put(_Begin(at, first, gap))

    def close(self) -> None:
        """Write the rest, and the index; what takes longer than two seconds is given up. May be called again."""
        self._queue.put(None)
        self._thread.join(END_S)

    def _lose(self, at: int, records: int, why: str) -> None:
        with self._lock:
            gap = self._gap or Gap(at, 0, why)
            self._gap = Gap(gap.since, gap.records + records, gap.why)
        self._say(f"The trace of {self._program} is not recorded: {why} ({self._folder}).")

    def _say(self, trouble: str) -> None:
        before, self.trouble = self.trouble, trouble
        if bool(before) == bool(trouble):
            self.trouble = before  # in the words of its beginning: it does not flicker
            return
        if trouble:
            _log.warning("%s", trouble)
        else:
            _log.warning("The trace of %s is recorded again: %s", self._program, self.path)
        if self.on_trouble is None:
            return
        try:
            self.on_trouble()
        except Exception:  # noqa: BLE001 what it does ends no recording
            _log.exception("the failure of a trace could not be reported")

    # From here on: in the writer's thread.

    def _run(self) -> None:
        while True:
            waits_for_room = self._gap is not None and not self.wants_state
            try:
                entry = self._queue.get(timeout=RETRY_S if waits_for_room else None)
            except queue.Empty:
                self._prepare()
                continue
            if entry is None:
                break
            if isinstance(entry, _Begin):
                self._begin(entry)
            else:
                self._take(entry)
        self._end()

    def _take(self, batch: Sequence[Entry]) -> None:
        self._write(batch)
        with self._lock:
            self._queued -= len(batch)

    def _write(self, batch: Sequence[Entry]) -> None:
        segment = self._segment
        if segment is None:
            self._lose(batch[0][1], len(batch), "the disk does not work")
            return
        try:
            for kind, at, content in batch:
                segment.add(kind, at, content)
            segment.write()
        except Exception as error:  # noqa: BLE001 a record that cannot be written ends no program
            self._segment = None
            segment.leave()
            self._lose(batch[0][1], len(batch), _why(error))
        else:
            if not self._ordered and segment.size >= self._full_at:
                self.wants_state = True

    def _begin(self, begin: _Begin) -> None:
        self._start(begin)
        self._ordered = False

    def _start(self, begin: _Begin) -> None:
        before, self._segment = self._segment, None
        fresh, self._fresh = self._fresh, None
        try:
            follows = before is not None and self._finish(before) and begin.gap is None
            fresh = fresh or self._make()
            preamble = fresh.size
            if self._header is not None:
                opening = Opening(begin.at, self._number + 1, follows, begin.gap)
                fresh.add(HEADER, begin.at, self._header(opening))
            for kind, at, content in begin.first:
                fresh.add(kind, at, content)
            fresh.write()
        except Exception as error:  # noqa: BLE001 it is tried again
            if fresh is not None:
                fresh.discard()
            gap = begin.gap or Gap(begin.at, 0, _why(error))
            self._lose(gap.since, gap.records + len(begin.first), gap.why)
            return
        self._number += 1
        self._segment, self._full_at = fresh, preamble + self._limits.segment_bytes
        if self._gap is None:
            self._say("")

    def _prepare(self) -> None:
        """Whether the disk works again: then there is a file for the next segment."""
        try:
            self._fresh = self._fresh or self._make()
        except Exception:  # noqa: BLE001 it does not
            return
        before, self._segment = self._segment, None
        if before is not None:
            self._finish(before)
        self.wants_state = True

    def _make(self) -> SegmentFile:
        if self._folder.is_dir():
            remove_leftovers(self._folder)
            make_room(self._folder, self._limits)
        return SegmentFile(
            self._folder, self._program, self._kinds, attachments=self._attachments, day_us=self._day_us
        )

    def _end(self) -> None:
        if self._segment is not None:
            self._finish(self._segment, last=True)
        if self._fresh is not None:
            self._fresh.discard()

    def _finish(self, segment: SegmentFile, *, last: bool = False) -> bool:
        """Close a segment and have it indexed; whether it could be closed with its checksum."""
        try:
            segment.finish()
        except OSError as error:
            _log.warning("%s has no checksum: %s", segment.path, error.strerror)
            return False
        try:
            if last or segment.size <= MEGABYTE:
                write_indexed(segment.path, monotonic() + INDEX_S)
            else:
                start_indexing(segment.path)
        except TooLongError:
            with suppress(OSError):  # it can be read as it is
                start_indexing(segment.path)
        except Exception as error:  # noqa: BLE001 it can be read as it is
            _log.info("%s has no index: %s", segment.path, error)
        return True


def _why(error: Exception) -> str:
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return str(error) if isinstance(error, ReportedError) else f"{type(error).__name__}: {error}"
