"""Both records of an arbiter, in memory and on a disk, and how far the next arbiter believes them."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._session_store import SessionStore
from end_effector_hal.arbiter.rules import Driven
from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from end_effector_hal.arbiter.rules._lines import UNKNOWN_ROLES, left_behind
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._predicates import FORMER
from end_effector_hal.arbiter.rules._session import ArbiterState, DrivenLine

_log = logging.getLogger("end_effector_hal.arbiter")


def recall(record: ArbiterState | None, journal: JournalEntry, boot: str = "") -> ArbiterState:
    """Return the state to start with: from the session record of this boot; without one, the faults of the journal.

    In doubt more faults are latched rather than fewer, no last will is executed, and any line may be active. ``boot``
    identifies this boot of the machine.
    """
    if record is not None and not record.doubt and not record.unread:
        return record
    if journal.doubt:
        _log.error("latched faults may be missing: %s", journal.doubt)
    faults = dict(journal.faults)
    if journal.doubt:
        faults["journal"] = f"Faults that were latched before the start may be missing: {journal.doubt}."
    # the journal may lag behind: an old "inactive" is not believed, what may be held is held
    pulsed = {
        line: level
        for line, level in journal.pulsed.items()
        if level or (journal.clean and not journal.doubt)
    }
    if record is not None and not record.doubt:  # made before the journal was read: only faults are missing
        return replace(record, faults={**faults, **record.faults})
    driven = _driven(journal, boot)
    if record is not None and record.driven:
        driven = {line: each._replace(active=True) for line, each in record.driven.items()}
    if journal.doubt and not driven and not journal.unread:
        faults[FORMER] = UNKNOWN_ROLES.format(journal.doubt)
    if record is not None:
        active = {line: level for line, level in pulsed.items() if level}
        return replace(record, faults={**faults, **record.faults}, pulsed=active, driven=driven)
    known = journal.clean and journal.boot  # an arbiter that ended in order has left nothing to be done
    doubt = "" if known else "no session record was found"
    return ArbiterState(faults, clean=journal.clean, doubt=doubt, pulsed=pulsed, driven=driven)


def _driven(journal: JournalEntry, boot: str) -> dict[str, DrivenLine]:
    """Return each line's role and possible state by the journal alone; a reboot has made board lines inactive."""
    restarted, certain = journal.boot != boot and bool(boot), journal.clean and not journal.doubt
    return {
        line: DrivenLine(role, not restarted if active is None else active or not certain)
        for line, (role, active) in journal.driven.items()
    }


def _to_disk(state: ArbiterState, policy: Policy) -> dict[str, DrivenLine]:
    """Return the roles for the journal; levels of board lines change too often for a disk, and a reboot resets them."""
    return {
        line: each if policy.roles[line].stays else each._replace(active=None)
        for line, each in state.driven.items()
    }


def recorded_left_behind(socket: Path, policy: Policy) -> str:
    """Apply `left_behind` to the newest session record in the socket's folder that has lines of this policy.

    A tool of another name has another socket but may drive the same lines.
    """
    records = (each for each in socket.parent.glob("*.sessions") if each.is_file())
    for path in sorted(records, key=lambda each: each.stat().st_mtime_ns, reverse=True):
        state = recall(SessionStore.beside(path.with_suffix("")).read(), JournalEntry({}))
        chips = {line: each.role.partition(" on ")[2] for line, each in state.driven.items()}
        if any(chips.get(line) == role.words.partition(" on ")[2] for line, role in policy.roles.items()):
            return left_behind(state, policy)
    return ""


NO_RECORD = "The session record cannot be kept ({}): if the line arbiter dies, no last will is executed."
NO_JOURNAL = (
    "The journal of the line arbiter cannot be written ({}): a loss of power would clear latched faults."
)


class JournalKeeper(Protocol):
    """Writes a journal without making the arbiter wait for the disk; see `JournalThread`."""

    @property
    def trouble(self) -> str:
        """Why the faults are not on the disk; empty: they are there or will be in a moment."""
        ...

    def read(self) -> JournalEntry:
        """Return the entry of an earlier arbiter."""
        ...

    def late(self) -> JournalEntry | None:
        """Return that entry, once, if the disk did not answer in time for `read`."""
        ...

    def keep(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven) -> None:
        """Request that this state be written."""
        ...

    def close(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven) -> None:
        """Write the final state of an arbiter that ends in order."""
        ...


class Records:
    """Reads and writes the session record and the journal. A failure of either is a latched fault and ends nothing."""

    def __init__(self, sessions: SessionStore, journal: JournalKeeper) -> None:
        self._sessions, self._journal = sessions, journal
        entry = journal.read()
        self._unread = entry.unread
        self._kept = ArbiterState()
        self.before_change = sessions.begin
        self.before = recall(sessions.read(), entry, sessions.boot)
        """The state of the previous arbiter."""

    @property
    def faults(self) -> Mapping[str, str]:
        """The latched faults as they were saved last."""
        return self._kept.faults

    def keep(self, arbiter: LineArbiter) -> None:
        """Save the arbiter's state; call this before any client learns of a change."""
        if late := self._journal.late():
            self._unread = False
            if not self.before.driven:
                late_roles = ArbiterState(driven=_driven(late, self._sessions.boot))
                unknown = UNKNOWN_ROLES.format(late.doubt) if late.doubt and not late.driven else ""
                if why := left_behind(late_roles, arbiter.policy) or unknown:
                    arbiter.predicates.latch(FORMER, why)
            for name, why in late.faults.items():
                arbiter.predicates.latch(name, why)
        self._latch_troubles(arbiter)
        state = arbiter.state
        self._sessions.keep(replace(state, unread=True) if self._unread else state)
        if self._latch_troubles(arbiter):  # before anybody learns of what is not kept
            state = arbiter.state
        if state != self._kept:
            self._kept = state
            self._journal.keep(state.faults, state.pulsed, _to_disk(state, arbiter.policy))

    def _latch_troubles(self, arbiter: LineArbiter) -> bool:
        """Return whether one of the records cannot be written now."""
        if troubled := bool(self._sessions.trouble or self._journal.trouble):
            for name, why in self.troubles().items():
                arbiter.predicates.latch(name, why)
        return troubled

    def troubles(self) -> dict[str, str]:
        """Return the records that cannot be written now, as faults: sentences by name."""
        return {
            name: sentence.format(why)
            for name, sentence, why in (
                ("session record", NO_RECORD, self._sessions.trouble),
                ("journal", NO_JOURNAL, self._journal.trouble),
            )
            if why
        }

    def close(self, state: ArbiterState, policy: Policy) -> None:
        """Save the final state of an arbiter that ends in order, and close the records."""
        self._sessions.keep(replace(state, clean=True, unread=self._unread))
        self._sessions.close()
        self._journal.close(state.faults, state.pulsed, _to_disk(state, policy))
