"""What the next line owner needs of this one's clients, kept in memory: their last wills, and the lines' levels.

It stands in a file of the run directory, which is memory (tmpfs): it outlives the process and not the machine, as the
lines do. Its room is taken at the start, so that a full disk does not concern it. Before a line changes, the record
is marked as outdated; it is whole again once the wills that go with the new levels are in it. Whatever is outdated,
damaged, of another boot, or does not fit the levels that are found means *hold*: no last will is executed.
"""

from __future__ import annotations

import contextlib
import json
import logging
from dataclasses import replace
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.wires.owner._memory import Memory, read_memory
from end_effector_hal.wires.owner._record_file import RecordFile, Standing
from end_effector_hal.wires.owner._storage import Storage

_log = logging.getLogger("end_effector_hal.owner")


class SessionRecord:
    """One file; trouble with it is an alarm and ends nothing.

    Args:
        storage: where; None: keep nothing.
        boot: names this start of the machine.
    """

    def __init__(self, storage: Storage | None, boot: str) -> None:
        self._storage, self._boot = storage, boot
        self._file = RecordFile(storage) if storage else None
        self._tried = b""
        self._begun = False
        self.trouble = ""
        """Why the record cannot be kept just now, a clause; empty: it is."""

    def read(self) -> Memory | None:
        """What the owner before this one has left in this boot, with its doubt; None: nothing."""
        if self._file is None:
            return None
        try:
            found = self._file.read()
        except OSError as error:
            return Memory(clean=False, doubt=f"the record of the sessions cannot be read ({error.strerror})")
        if found.standing is Standing.ABSENT:
            return None
        if found.standing is Standing.DAMAGED:
            return Memory(clean=False, doubt="the record of the sessions is damaged")
        try:
            given = json.loads(found.payload)
            if not self._boot or given["boot"] != self._boot:
                return None
            memory = read_memory(given["memory"])
        except (ValueError, KeyError, TypeError, UsageError, RecursionError):
            return Memory(clean=False, doubt="the record of the sessions is of another version")
        if found.standing is Standing.OUTDATED:
            return replace(
                memory, clean=False, doubt="the owner before this one died while it changed a line"
            )
        return memory

    def begin(self) -> None:
        """A line is about to change: the record is outdated until the next `keep`."""
        if self._file is not None and not self._begun:
            self._begun = True
            try:
                self._file.begin()
            except OSError as error:
                self._fail(error)

    def keep(self, memory: Memory) -> None:
        """Keep it, if it is something else than before or is outdated."""
        if self._file is None:
            return
        given = {"boot": self._boot, "memory": memory.as_json()}
        payload = json.dumps(given, separators=(",", ":")).encode()
        if payload == self._tried and not self._begun:
            return
        self._tried, self._begun = payload, False
        try:
            self._file.keep(payload)
        except OSError as error:
            self._fail(error)
        else:
            self.trouble = ""

    def close(self) -> None:
        """Give the file back."""
        if self._file is not None:
            self._file.close()

    def _fail(self, error: OSError) -> None:
        if not self.trouble:
            _log.error("the record of the sessions cannot be kept: %s", error.strerror)
        self.trouble = error.strerror or str(error)
        if self._storage is not None:
            # What stands there would be believed: without a record the next owner holds.
            with contextlib.suppress(OSError):
                self._storage.remove()


def this_boot() -> str:
    """The kernel's name for this start of the machine; "" where it has none, which equals no other."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""
