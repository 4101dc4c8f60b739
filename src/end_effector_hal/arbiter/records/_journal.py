"""The journal: latched faults on a disk, where they survive a power loss. The arbiter never waits for the disk.

A thread writes and syncs. If the thread has not written a change within a second, or a write fails, the arbiter raises
an alarm; the write is repeated at each change and every second. The sessions of the clients are kept elsewhere: see
`_session_store`.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from end_effector_hal.arbiter.protocol import read_record, write_message
from end_effector_hal.arbiter.records._record_file import RecordFile, Standing
from end_effector_hal.arbiter.records._storage import Storage
from end_effector_hal.arbiter.rules import Driven
from end_effector_hal.arbiter.rules._session import read_driven, read_faults, read_levels
from end_effector_hal.errors import UsageError

_log = logging.getLogger("end_effector_hal.arbiter")
PATIENCE_US = 1_000_000
"""Time without an answer after which the disk counts as hanging, µs."""
RETRY_S = 1.0
READ_S = 2.0
"""Longest wait for the disk at the start and at the end of an arbiter, s."""

NONE: Driven = MappingProxyType({})


class JournalEntry(NamedTuple):
    """The content of the journal.

    Attributes:
        faults: sentences by name, latched until a reset.
        clean: whether the arbiter ended in order.
        boot: identifies the boot of the machine in which the journal was written.
        doubt: why faults may be missing, a clause; empty: none is missing.
        pulsed: levels of the outputs whose level cannot be read from their lines (driven by pulses).
        unread: the disk has not answered yet; its content follows later.
        driven: the role of each line. Whether a line may be active is recorded only for lines that stay active without
            this machine.
    """

    faults: Mapping[str, str]
    clean: bool = True
    boot: str = ""
    doubt: str = ""
    pulsed: Mapping[str, bool] = MappingProxyType({})
    unread: bool = False
    driven: Driven = NONE


NO_ANSWER = JournalEntry(
    {}, clean=False, doubt="its journal cannot be read (the disk does not answer)", unread=True
)
"""The entry for a disk that has not answered in time."""


class Journal:
    """Keeps the faults of one arbiter. Only `read`, `begin`, `write_next` and `close` wait for the disk.

    Args:
        storage: the file; None: nothing is kept.
        boot: identifies this boot of the machine.
        clock: monotonic, µs.
    """

    def __init__(self, storage: Storage | None, boot: str, clock: Callable[[], int]) -> None:
        self._file = RecordFile(storage) if storage else None
        self._storage, self._boot, self._clock = storage, boot, clock
        self._lock = threading.Lock()
        self.changed = threading.Event()
        """Set when there may be a change to write."""
        self._asked: tuple[object, ...] = ()
        self._wanted = self._written = b""
        self._since: int | None = None  # when the oldest of what is not on the disk was wanted
        self._error = ""

    def read(self) -> JournalEntry:
        """Return the entry of an earlier arbiter; waits for the disk."""
        if self._file is None:
            return JournalEntry({})
        try:
            found = self._file.read()
        except OSError as error:
            return JournalEntry({}, clean=False, doubt=f"its journal cannot be read ({error.strerror})")
        if found.standing is Standing.ABSENT:
            return JournalEntry({})
        if found.standing is Standing.DAMAGED:
            return JournalEntry({}, clean=False, doubt="its journal is damaged")
        try:
            entry = read_record(found.payload, _entry)
        except UsageError:
            return JournalEntry({}, clean=False, doubt="its journal is of another version")
        if found.standing is Standing.OUTDATED:
            return entry._replace(clean=False, doubt="the last record of its journal is torn", pulsed={})
        return entry

    def keep(
        self,
        faults: Mapping[str, str],
        pulsed: Mapping[str, bool] = MappingProxyType({}),
        driven: Driven = NONE,
        *,
        clean: bool = False,
    ) -> None:
        """Request that this state be written, if it differs from the last request; returns at once."""
        wanted = dict(faults), dict(pulsed), dict(driven), clean
        if self._file is None or wanted == self._asked:
            return
        self._asked = wanted
        payload = self._payload(faults, pulsed, driven, clean=clean)
        with self._lock:
            self._wanted = payload
            if self._since is None:
                self._since = self._clock()
        self.changed.set()

    def begin(self, entry: JournalEntry) -> JournalEntry:
        """Mark the previous arbiter's entry as unclean on the disk, because outputs may change now; waits for the
        disk.

        Without this, a power loss just after the next pulse would leave "inactive" on the disk for an output that is
        active. Returns the entry that the new arbiter may believe.
        """
        idle = False in entry.pulsed.values() or any(each.active is False for each in entry.driven.values())
        if self._file is None or not entry.clean or not idle:
            return entry
        payload = self._payload(entry.faults, entry.pulsed, entry.driven, clean=False)
        try:
            self._file.keep(payload, synced=True)
        except OSError:
            return entry._replace(clean=False)
        with self._lock:
            self._written = payload
        return entry

    def _payload(
        self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven, *, clean: bool
    ) -> bytes:
        content: dict[str, object] = {"boot": self._boot, "clean": clean, "faults": dict(faults)}
        content |= {"driven": dict(driven)} if driven else {}
        return write_message(content | ({"pulsed": dict(pulsed)} if pulsed else {}))

    def write_next(self) -> bool:
        """Write the latest state that `keep` requested; return whether it is on the disk now. Waits for the disk."""
        with self._lock:
            payload = self._wanted
            if self._file is None or payload == self._written:
                self._since, self._error = None, ""
                return True
        try:
            self._file.keep(payload, synced=True)
        except OSError as error:
            with self._lock:
                if not self._error:
                    _log.error("the journal of the line arbiter cannot be written: %s", error.strerror)
                self._error = error.strerror or str(error)
            return False
        with self._lock:
            self._written, self._error = payload, ""
            self._since = None if payload == self._wanted else self._clock()
        return True

    def close(self) -> None:
        """Close the file."""
        if self._storage is not None:
            self._storage.close()

    @property
    def trouble(self) -> str:
        """Why the faults are not on the disk, a clause; empty: they are there or will be in a moment."""
        with self._lock:
            if self._error:
                return self._error
            late = self._since is not None and self._clock() - self._since > PATIENCE_US
            return "the disk does not answer" if late else ""


class JournalThread:
    """Reads and writes a journal in a thread, so that the arbiter does not wait for the disk.

    Args:
        journal: the journal; from now on only this thread uses it.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal, self._ended = journal, False
        self._was_read, self._taken = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def read(self) -> JournalEntry:
        """Return the entry of an earlier arbiter; `NO_ANSWER` if the disk does not answer within 2 s, see `late`."""
        self._was_read.wait(READ_S)
        return self.late() or NO_ANSWER

    def late(self) -> JournalEntry | None:
        """Return the entry of an earlier arbiter, once; else None. Nothing is written before it was returned."""
        if self._taken.is_set() or not self._was_read.is_set():
            return None
        self._taken.set()
        return self._entry

    def keep(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven = NONE) -> None:
        """Request that this state be written; returns at once."""
        self._journal.keep(faults, pulsed, driven)

    @property
    def trouble(self) -> str:
        """Why the faults are not on the disk; see `Journal.trouble`."""
        return self._journal.trouble

    def close(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven = NONE) -> None:
        """Write the final state of an arbiter that ends in order; wait at most 2 s for a pending read, and 2 s for
        this.
        """
        if not self._taken.is_set():
            self._was_read.wait(READ_S)
            if (late := self.late()) is None:
                _log.error(
                    "the line arbiter ends without its journal, which stays as it is: the disk does not answer"
                )
                return
            faults = {**late.faults, **faults}
        self._journal.keep(faults, pulsed, driven, clean=True)
        self._ended = True
        self._journal.changed.set()
        self._thread.join(READ_S)
        if self._thread.is_alive():
            _log.error("the line arbiter ends, and the disk of its journal does not answer")

    def _run(self) -> None:
        self._entry = self._journal.begin(self._journal.read())
        self._was_read.set()
        self._taken.wait()
        done = True
        while True:
            self._journal.changed.wait(None if done else RETRY_S)
            self._journal.changed.clear()
            ended = self._ended  # read first: what `keep` asked for until then is still written
            done = self._journal.write_next()
            if ended:
                return self._journal.close()


def _entry(given: Any) -> JournalEntry:
    pulsed = read_levels(given.get("pulsed", {}))
    faults, driven = read_faults(given["faults"]), read_driven(given)
    return JournalEntry(faults, bool(given["clean"]), str(given["boot"]), pulsed=pulsed, driven=driven)
