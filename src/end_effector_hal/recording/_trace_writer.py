"""Write the boundary records of a run to MCAP files as they happen, segment by segment."""

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

from ._files import MEGABYTE, RecordingLimits, make_room
from ._indexed import TooLongError, remove_leftovers, start_indexing, write_indexed
from ._segment import SegmentFile

_log = logging.getLogger("end_effector_hal.recording")
MOST_WAITING = 3_000
"""Maximum number of records that wait for a slow disk; a program produces as many in half a minute."""
RETRY_S = 1.0
"""Time after which a failed disk is tried again, s."""
END_S = 2.0
"""Longest time that the end of a program waits for its disk, s."""
INDEX_S = 1.5
"""Longest time for which the writer's thread sorts a short segment, or the last one, s; longer ones get a separate
process.
"""
HEADER = "header"

Entry = tuple[str, int, object]
"""A record: kind, time and content."""


@dataclass(frozen=True, slots=True)
class Gap:
    """The records that are missing before a segment.

    Attributes:
        since: time of the first record that was not written, µs.
        records: number of records that were not written.
        why: the reason in words.
    """

    since: int
    records: int
    why: str


class Opening(NamedTuple):
    """The facts about a new segment from which its header is made.

    Attributes:
        at: time, µs on the monotonic clock.
        segment: number of the segment since the start of the program, from 1 on.
        follows: whether the previous segment was closed normally, and no records are missing between the two.
        gap: the missing records before the segment; None: no records are missing.
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
    """Writes records in its own thread, each batch at once, so that written records survive a kill of the process.

    `put` and `begin` never wait and never raise, so that recording delays no reaction. Only one thread at a time may
    call them. Only the writer's thread creates, writes and closes files. While the disk fails, nothing is recorded and
    :attr:`trouble` gives the reason; the writer retries every second.

    The recorder checks :attr:`wants_state` after each batch: it is set when a file is long enough, or the disk works
    again. Then `begin` starts the next segment, with the records that make it readable without the previous one.

    Args:
        folder: created if it is missing; its files are ``hal.mcap``, ``hal-2.mcap``, …
        kinds: name of each kind of record, which is in its topic ``/hal/kind``, and the dataclass of its content.
        now: current time on the monotonic clock of the run, µs, to convert times to the time of day, as in other
            recordings.
        attachments: name and content of files that belong to the run; every segment contains them.
        header: makes the first record of a segment, of the kind ``header``; None: there is none.
        limits: the limits of the folder.
        on_trouble: called when :attr:`trouble` has changed, in any thread; must not wait.
    """

    def __init__(
        self,
        folder: str | Path,
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
        """A sentence why nothing is recorded now; empty: recording works."""
        self.wants_state = False
        """Whether the next segment can begin."""
        self._folder, self._kinds, self._attachments = Path(folder), kinds, attachments
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
        self._thread = threading.Thread(target=self._run, name="trace", daemon=True)
        self._thread.start()

    @property
    def path(self) -> Path | None:
        """Path of the segment that is being written; None: no segment is being written."""
        return self._segment.path if self._segment is not None else None

    def put(self, batch: Sequence[Entry]) -> None:
        """Queue records, with times in µs on the monotonic clock; return at once."""
        if not batch:
            return
        with self._lock:
            room = self._gap is None and self._queued + len(batch) <= MOST_WAITING
            self._queued += len(batch) if room else 0
        if room:
            self._queue.put(batch)
        else:
            self._lose(batch[0][1], len(batch), "the disk is too slow for the records")

    def begin(self, at: int, first: Sequence[Entry]) -> None:
        """Begin the next segment at ``at`` µs, with these records after its header; return at once."""
        with self._lock:
            gap, self._gap = self._gap, None
            self.wants_state, self._ordered = False, True
        self._queue.put(_Begin(at, first, gap))

    def close(self) -> None:
        """Write the remaining records and the index; stop waiting after two seconds. May be called again."""
        self._queue.put(None)
        self._thread.join(END_S)

    def _lose(self, at: int, records: int, why: str) -> None:
        with self._lock:
            gap = self._gap or Gap(at, 0, why)
            self._gap = Gap(gap.since, gap.records + records, gap.why)
        self._say(f"The trace is not recorded: {why} ({self._folder}).")

    def _say(self, trouble: str) -> None:
        before, self.trouble = self.trouble, trouble
        if bool(before) == bool(trouble):
            self.trouble = before  # in the words of its beginning: it does not flicker
            return
        if trouble:
            _log.warning("%s", trouble)
        else:
            _log.warning("The trace is recorded again: %s", self.path)
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
        """Check whether the disk works again; if so, create the file of the next segment."""
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
        return SegmentFile(self._folder, self._kinds, attachments=self._attachments, day_us=self._day_us)

    def _end(self) -> None:
        if self._segment is not None:
            self._finish(self._segment, last=True)
        if self._fresh is not None:
            self._fresh.discard()

    def _finish(self, segment: SegmentFile, *, last: bool = False) -> bool:
        """Close a segment and index it; return whether it could be closed with its checksum."""
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
