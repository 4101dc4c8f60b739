"""What the next line owner must know: the record of the sessions in memory, the journal of the faults on a disk."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._recall import recall
from end_effector_hal.arbiter.records._session_store import SessionStore
from end_effector_hal.arbiter.rules import ArbiterState, LineArbiter

NO_RECORD = (
    "The record of the sessions cannot be kept ({}): if the line owner dies, no last will is executed."
)
NO_JOURNAL = (
    "The journal of the line owner cannot be written ({}): a loss of power would clear latched faults."
)


class FaultJournal(Protocol):
    """A journal for which nobody waits; see `JournalThread`."""

    @property
    def trouble(self) -> str:
        """Why the faults are not on the disk, a clause; empty: they are."""
        ...

    def read(self) -> JournalEntry:
        """What an earlier owner has left."""
        ...

    def late(self) -> JournalEntry | None:
        """The same, when the disk did not answer in time; once."""
        ...

    def keep(self, faults: dict[str, str]) -> None:
        """Have this written."""
        ...

    def close(self, faults: dict[str, str]) -> None:
        """The owner ends in order."""
        ...


class Records:
    """Both of them, for one owner. Trouble with them is a latched fault and ends nothing."""

    def __init__(self, sessions: SessionStore, journal: FaultJournal) -> None:
        self._sessions, self._journal = sessions, journal
        self.before = recall(sessions.read(), journal.read())
        """What the owner before this one has left."""

    def before_change(self) -> None:
        """Lines are about to be written: what is recorded is outdated until `keep`."""
        self._sessions.begin()

    def keep(self, keeper: LineArbiter) -> None:
        """Before anybody is told what has changed."""
        if late := self._journal.late():
            for name, why in late.faults.items():
                keeper.sensed.latch(name, why)
        for name, why in self.troubles().items():
            keeper.sensed.latch(name, why)
        memory = keeper.memory
        self._sessions.keep(memory)
        self._journal.keep(dict(memory.faults))

    def troubles(self) -> dict[str, str]:
        """What cannot be kept just now, as faults: sentences by name."""
        return {
            name: sentence.format(why)
            for name, sentence, why in (
                ("session record", NO_RECORD, self._sessions.trouble),
                ("journal", NO_JOURNAL, self._journal.trouble),
            )
            if why
        }

    def close(self, memory: ArbiterState) -> None:
        """The owner ends in order."""
        self._sessions.keep(replace(memory, clean=True))
        self._sessions.close()
        self._journal.close(dict(memory.faults))
