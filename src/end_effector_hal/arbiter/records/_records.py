"""Both records of one arbiter: the session record in memory, the journal of its faults on a disk."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._recall import recall
from end_effector_hal.arbiter.records._session_store import SessionStore
from end_effector_hal.arbiter.rules import ArbiterState, LineArbiter

NO_RECORD = "The session record cannot be kept ({}): if the line arbiter dies, no last will is executed."
NO_JOURNAL = (
    "The journal of the line arbiter cannot be written ({}): a loss of power would clear latched faults."
)


class FaultJournal(Protocol):
    """A journal that never makes its user wait; see `JournalThread`."""

    @property
    def trouble(self) -> str:
        """Why the faults are not on the disk, a clause; empty: they are."""
        ...

    def read(self) -> JournalEntry:
        """What an earlier arbiter has written."""
        ...

    def late(self) -> JournalEntry | None:
        """The same, once, when the disk answered only after `read`; else None."""
        ...

    def keep(self, faults: dict[str, str]) -> None:
        """Have these faults written."""
        ...

    def close(self, faults: dict[str, str]) -> None:
        """The arbiter ends in order."""
        ...


class Records:
    """Reads and keeps them. Trouble with either is a latched fault and ends nothing."""

    def __init__(self, sessions: SessionStore, journal: FaultJournal) -> None:
        self._sessions, self._journal = sessions, journal
        self.before = recall(sessions.read(), journal.read())
        """The state of the arbiter before this one."""

    def before_change(self) -> None:
        """Lines are about to be written: what is recorded is outdated until `keep`."""
        self._sessions.begin()

    def keep(self, arbiter: LineArbiter) -> None:
        """Keep its state; call it before any client learns what has changed."""
        if late := self._journal.late():
            for name, why in late.faults.items():
                arbiter.predicates.latch(name, why)
        for name, why in self.troubles().items():
            arbiter.predicates.latch(name, why)
        state = arbiter.state
        self._sessions.keep(state)
        self._journal.keep(dict(state.faults))

    def troubles(self) -> dict[str, str]:
        """Records that cannot be kept now, as faults: sentences by name."""
        return {
            name: sentence.format(why)
            for name, sentence, why in (
                ("session record", NO_RECORD, self._sessions.trouble),
                ("journal", NO_JOURNAL, self._journal.trouble),
            )
            if why
        }

    def close(self, state: ArbiterState) -> None:
        """The arbiter ends in order."""
        self._sessions.keep(replace(state, clean=True))
        self._sessions.close()
        self._journal.close(dict(state.faults))
