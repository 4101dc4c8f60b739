"""The session record: last wills and levels of the lines, for the next arbiter, in memory that outlives the process.

The record is a file in the run directory, which is memory (tmpfs): like the levels of the lines, it outlives the
process but not the machine. Its space is allocated at the start, so that a full disk does not matter later. Before a
line changes, the record is marked as outdated; it is whole again once it contains the last wills for the new levels.
If a record is outdated, damaged, from another boot, not the latest by its number, or does not match the levels found,
the arbiter *holds*: no last will is executed.
"""

from __future__ import annotations

import contextlib
import logging
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from end_effector_hal.arbiter.protocol import read_record, write_message
from end_effector_hal.arbiter.records._record_file import RecordFile, Standing
from end_effector_hal.arbiter.records._storage import FileStorage, Storage
from end_effector_hal.arbiter.rules._session import ArbiterState, read_arbiter_state
from end_effector_hal.errors import UsageError
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
RETRY_US = 1_000_000
_MARK = struct.Struct("<Q")


class SessionStore:
    """Keeps the session record in one file; a failure to do so is an alarm and ends nothing.

    Args:
        storage: the file of the record.
        mark: a second file with the number of the latest record: an older record that is whole, for example a copy,
            does not match it.
        boot: identifies this boot of the machine.
        clock: monotonic, µs.
    """

    def __init__(self, storage: Storage, mark: Storage, boot: str, clock: Callable[[], int]) -> None:
        self._mark, self.boot, self._clock = mark, boot, clock
        self._retry_at = 0
        self._file = RecordFile(storage)
        self._marked = False
        self._tried: ArbiterState | None = None
        self._begun = False
        self.trouble = ""
        """Why the record cannot be written now, a clause; empty: it is written."""

    @classmethod
    def beside(cls, socket: Path) -> SessionStore:
        """Return the store of the arbiter that serves, or served, this socket."""
        record, mark = (
            FileStorage(Path(f"{socket}.{name}"), durable=False) for name in ("sessions", "generation")
        )
        return cls(record, mark, this_boot(), now_us)

    def read(self) -> ArbiterState | None:
        """Return the state of the previous arbiter in this boot, with any doubt about it; None: there is none."""
        try:
            found, mark = self._file.read(), self._mark.read()
        except OSError as error:
            return ArbiterState(clean=False, doubt=f"the session record cannot be read ({error.strerror})")
        self._marked = len(mark) == _MARK.size
        if found.standing is Standing.ABSENT:
            return None
        if found.standing is Standing.DAMAGED:
            return ArbiterState(clean=False, doubt="the session record is damaged")
        try:
            boot, given = read_record(found.payload, lambda given: (given["boot"], given["memory"]))
            if not self.boot or boot != self.boot:
                return None
            state = read_arbiter_state(given)
        except UsageError:
            return ArbiterState(clean=False, doubt="the session record is of another version")
        doubt = ""
        if found.standing is Standing.OUTDATED:
            doubt = (
                "the arbiter before this one died while it changed a line, or a part of its record is missing"
            )
        elif mark != _MARK.pack(found.generation):
            doubt = "the session record is not the latest one"
        return replace(state, clean=False, doubt=doubt) if doubt else state

    def begin(self) -> None:
        """Mark the record as outdated until the next `keep`, because a line is about to change."""
        if not self._begun:
            self._begun = True
            try:
                self._file.begin()
            except OSError as error:
                self._fail(error)

    def keep(self, state: ArbiterState) -> None:
        """Write the record if the state has changed, the record is outdated, or a failed write is due again."""
        due = bool(self.trouble) and self._clock() >= self._retry_at
        if state == self._tried and not self._begun and not due:
            return
        self._tried, self._begun = state, False
        payload = write_message({"boot": self.boot, "memory": state.as_json()})
        try:
            self._write_mark(_MARK.pack(self._file.next_generation))
            self._file.keep(payload)
        except OSError as error:
            self._fail(error)
        else:
            self.trouble = ""

    def close(self) -> None:
        """Close both files."""
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
            _log.error("the session record cannot be kept: %s", error.strerror)
        self.trouble, self._retry_at = error.strerror or str(error), self._clock() + RETRY_US
        # The next arbiter would believe what stands there; without a record it holds.
        self._marked = False
        for remove in (self._file.remove, self._mark.remove):
            with contextlib.suppress(OSError):
                remove()


def this_boot() -> str:
    """Return the kernel's identifier of this boot; "" if the kernel has none (it never equals another boot)."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""
