"""What the next line owner needs of this one's clients, kept in memory: their last wills, and the lines' levels.

It stands in a file of the run directory, which is memory (tmpfs): it outlives the process and not the machine, as the
lines do. Its room is taken at the start, so that a full disk does not concern it. Before a line changes, the record
is marked as outdated; it is whole again once the wills that go with the new levels are in it. Whatever is outdated,
damaged, not the latest by its number, of another boot, or does not fit the levels that are found means *hold*: no last
will is executed.
"""

from __future__ import annotations

import contextlib
import json
import logging
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from end_effector_hal.arbiter.records._record_file import RecordFile, Standing
from end_effector_hal.arbiter.records._storage import Storage
from end_effector_hal.arbiter.rules import ArbiterState, read_arbiter_state
from end_effector_hal.errors import UsageError

_log = logging.getLogger("end_effector_hal.arbiter")
RETRY_US = 1_000_000
_MARK = struct.Struct("<Q")


class SessionStore:
    """One file; trouble with it is an alarm and ends nothing.

    Args:
        storage: where.
        mark: where the number of the latest record stands, apart from the record: an older one that is whole, such as
            a copy, does not match it.
        boot: names this start of the machine.
        clock: monotonic, µs.
    """

    def __init__(self, storage: Storage, mark: Storage, boot: str, clock: Callable[[], int]) -> None:
        self._mark, self._boot, self._clock = mark, boot, clock
        self._retry_at = 0
        self._file = RecordFile(storage)
        self._marked = False
        self._tried: ArbiterState | None = None
        self._begun = False
        self.trouble = ""
        """Why the record cannot be kept just now, a clause; empty: it is."""

    def read(self) -> ArbiterState | None:
        """What the owner before this one has left in this boot, with its doubt; None: nothing."""
        try:
            found, mark = self._file.read(), self._mark.read()
        except OSError as error:
            return ArbiterState(
                clean=False, doubt=f"the record of the sessions cannot be read ({error.strerror})"
            )
        self._marked = len(mark) == _MARK.size
        if found.standing is Standing.ABSENT:
            return None
        if found.standing is Standing.DAMAGED:
            return ArbiterState(clean=False, doubt="the record of the sessions is damaged")
        try:
            given = json.loads(found.payload)
            if not self._boot or given["boot"] != self._boot:
                return None
            memory = read_arbiter_state(given["memory"])
        except (ValueError, KeyError, TypeError, UsageError, RecursionError):
            return ArbiterState(clean=False, doubt="the record of the sessions is of another version")
        doubt = ""
        if found.standing is Standing.OUTDATED:
            doubt = "the owner before this one died while it changed a line, or a part of its record has gone"
        elif mark != _MARK.pack(found.generation):
            doubt = "the record of the sessions is not the latest one"
        return replace(memory, clean=False, doubt=doubt) if doubt else memory

    def begin(self) -> None:
        """A line is about to change: the record is outdated until the next `keep`."""
        if not self._begun:
            self._begun = True
            try:
                self._file.begin()
            except OSError as error:
                self._fail(error)

    def keep(self, memory: ArbiterState) -> None:
        """Keep it, if it is something else than before, or is outdated, or could not be kept for a while."""
        due = bool(self.trouble) and self._clock() >= self._retry_at
        if memory == self._tried and not self._begun and not due:
            return
        self._tried, self._begun = memory, False
        given = {"boot": self._boot, "memory": memory.as_json()}
        payload = json.dumps(given, separators=(",", ":")).encode()
        try:
            self._write_mark(_MARK.pack(self._file.next_generation))
            self._file.keep(payload)
        except OSError as error:
            self._fail(error)
        else:
            self.trouble = ""

    def close(self) -> None:
        """Give the file back."""
        self._file.close()
        self._mark.close()

    def _write_mark(self, mark: bytes) -> None:
        if self._marked:
            self._marked = False  # until this write has succeeded
            self._mark.write(0, mark)
        else:
            self._mark.create(mark, _MARK.size)
        self._marked = True

    def _fail(self, error: OSError) -> None:
        if not self.trouble:
            _log.error("the record of the sessions cannot be kept: %s", error.strerror)
        self.trouble, self._retry_at = error.strerror or str(error), self._clock() + RETRY_US
        # What stands there would be believed: without a record the next owner holds.
        self._marked = False
        for remove in (self._file.remove, self._mark.remove):
            with contextlib.suppress(OSError):
                remove()


def this_boot() -> str:
    """The kernel's name for this start of the machine; "" where it has none, which equals no other."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""
