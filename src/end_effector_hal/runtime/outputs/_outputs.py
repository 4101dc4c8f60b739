"""Write the outputs of statuses to the line arbiter, with the last will that fits them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import NamedTuple, Protocol

from end_effector_hal.control import Status, maintenance_will
from end_effector_hal.errors import ArbiterError, LineBusyError, LineRefusedError, ReportedError, WireError
from end_effector_hal.vocabulary import ARBITER_LOST, NO_PART, Alarm, LastWillStep, WrittenPart

from ._output_mapping import OutputMapping

_log = logging.getLogger("end_effector_hal.runtime")
RETRY_US = 200_000
"""Time after which a failed access to the lines is repeated, µs."""
RESTARTED = "the program has restarted."
DECLARED_DEAD = f"The line arbiter declared this program dead and executed its last will; {RESTARTED}"


class LineWriter(Protocol):
    """The methods of the line arbiter that a program calls."""

    def levels(self) -> Mapping[str, bool]:
        """Return the level of every line."""

    def recorded_part(self) -> str:
        """Return the name of the part that was gripped last; empty: none, or it has no name."""

    def declared_dead(self) -> bool:
        """Return whether the line arbiter has declared this program dead since the last call."""

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        """Begin to write levels and the last will of this program; ``drop`` and ``part``: see `LineArbiter.write`.

        The returned function waits for the reply, and returns the time until all writes of this program are applied
        (IL-10), µs; 0: they are.
        """

    def close(self, will: Sequence[LastWillStep]) -> None:
        """Close the connection in good order; the will is executed at once."""


class LineWrite(NamedTuple):
    """One write to the line arbiter; see `LineWriter.ask`."""

    changes: dict[str, bool]
    will: tuple[LastWillStep, ...]
    drop: bool = False
    part: WrittenPart = NO_PART


class _Asked(NamedTuple):
    """A write that was begun; ``error`` is set if it could not be begun."""

    changes: Mapping[str, bool]
    will: tuple[LastWillStep, ...]
    at: int
    wait: Callable[[], int]
    error: ReportedError | None = None


class Outputs:
    """Writes changes of the lines; an activation that failed is not repeated later by itself (IL-11).

    After the line arbiter was ``lost``, nothing is certain until `agree` has compared the lines with what was written:
    the arbiter may have executed the last will.

    Args:
        lines: the line arbiter.
        mapping: maps a status to lines.
        known: the last known levels.
    """

    def __init__(
        self, lines: LineWriter, mapping: OutputMapping, known: Mapping[str, bool] | None = None
    ) -> None:
        self._lines, self.mapping = lines, mapping
        self.known = dict(known or {})
        """The last known level of each line; a line that was possibly activated counts as active."""
        self._wanted: dict[str, bool] | None = None
        self._said: tuple[LastWillStep, ...] | None = None
        self._undone: dict[str, bool] = {}
        self._leased: set[str] = set()
        self._written: dict[str, bool] = {}
        self._unheard: set[str] = set()
        self._dropped = ""
        self._attempt = 0
        self._asked: _Asked | None = None
        self._hastened: LineWrite | None = None
        self.lost = False
        self.disagreement = ""
        """A sentence why the lines are not as they were written, after `agree` has returned False."""
        self.retry_at: int | None = None
        self.settles_at: int | None = None
        """Time at which the last write is applied, µs: lines have to settle (IL-10). None: it is applied."""
        self.alarm: Alarm | None = None
        self.refused = {False: "", True: ""}
        """Sentences why the line arbiter refused the last activation of an actuator (False) and of the unlock output
        (True); empty again after it accepts one.
        """
        self.objected: set[bool] = set()
        """The keys of `refused` whose refusal is new: the automata have not processed it yet."""

    def found(self, levels: Mapping[str, bool], status: Status) -> None:
        """Store the levels that a program adopts as it begins; `agree` detects changes since they were read."""
        self._written = {line: levels[line] for line in self.mapping.levels(status) if line in levels}
        self.known |= levels

    @property
    def activated(self) -> frozenset[str]:
        """The lines that this program has activated and not requested to deactivate."""
        return frozenset(line for line, level in self._written.items() if level)

    @property
    def owes(self) -> bool:
        """Whether a decided deactivation is not written yet; those at the end of a maintenance lease do not count."""
        return not self._undone.keys() <= self._leased

    def begin(self, statuses: Sequence[Status]) -> Sequence[Status]:
        """Begin to write the first status that changes something, and return the statuses after it.

        This never waits; `complete` does. Before the lines are adopted nothing is written. A change of the last will
        alone is not written if a status of the same instant follows that deactivates lines: the two are one write.
        """
        number, write = self._first(statuses)
        if self._hastened is not None:
            return self._checked(statuses, number, write)
        if write is None:
            return ()
        self._ask(write, statuses[number].at)
        return statuses[number + 1 :]

    def _first(self, statuses: Sequence[Status]) -> tuple[int, LineWrite | None]:
        """Return the number of the first status that changes something, and its write; None: none does."""
        for number, status in enumerate(statuses):
            if not status.adopted:
                continue
            wanted, will = self.mapping.levels(status), self.mapping.last_will(status)
            changes = {} if wanted == self._wanted else self._changes(wanted)
            if self._unheard and status.attempt > self._attempt:
                # the lost arbiter could not activate them, and the next attempt still requests them
                changes |= {line: True for line in sorted(self._unheard) if wanted.get(line)}
            self._attempt = status.attempt
            before = self._dropped
            self._dropped = self.mapping.dropped(status) if status.dropped >= 0 else ""
            if drop := self._dropped not in ("", before):
                changes |= {self._dropped: False}
            if self.objected:  # the automata went on before they knew: nothing comes after what was refused
                changes = {line: False for line, level in changes.items() if not level}
            self._wanted = wanted
            if not changes and (
                will == self._said or self._deactivates(statuses[number + 1 : number + 2], status)
            ):
                continue
            part = self.mapping.grips(status, changes)
            return number, LineWrite({**self._undone, **changes}, will, drop, part)
        return len(statuses) - 1, None

    @property
    def basis(self) -> object:
        """A value that is equal as long as equal statuses are written equally."""
        maintenance, unheard, objected = (
            self.mapping.maintenance_lines,
            frozenset(self._unheard),
            frozenset(self.objected),
        )
        done = self._wanted, self._said, self._undone, self._attempt, self._dropped
        return *done, unheard, objected, self.lost, maintenance

    def foresee(self, statuses: Sequence[Status]) -> LineWrite | None:
        """Return what `begin` would write first after these statuses; None: nothing."""
        return None if self.lost else copy(self)._first(statuses)[1]

    def hasten(self, write: LineWrite, at: int) -> None:
        """Begin a write that was foreseen, before its statuses exist; `begin` compares it with what they request."""
        self._ask(write, at)
        self._hastened = write

    def _checked(self, statuses: Sequence[Status], number: int, write: LineWrite | None) -> Sequence[Status]:
        """Compare the hastened write with the one that is requested; return the statuses that remain to be written."""
        hastened, self._hastened = self._hastened, None
        if hastened == write:
            return statuses[number + 1 :]
        _log.error("The write %s was foreseen, but the automata decided %s.", hastened, write)
        self._wanted = self._said = None  # all levels are written next
        return statuses[number:]

    def complete(self, unwritten: Sequence[Status]) -> None:
        """Wait until the write is done, then write the statuses that `begin` has returned."""
        self.finish()
        while unwritten:
            unwritten = self.begin(unwritten)
            self.finish()

    def finish(self) -> None:
        """Wait until the write is done; an error becomes :attr:`alarm`."""
        asked, self._asked = self._asked, None
        if asked is None:
            return
        try:
            if asked.error is not None:
                raise asked.error
            delay_us = self._end(asked.changes, asked.wait)
            # asked again by then: a deactivation that fails waits for longer
            self.settles_at = asked.at + min(delay_us, RETRY_US) if delay_us > 0 else None
            self.alarm, self._said, self._undone, self.retry_at = None, asked.will, {}, None
            self._leased.clear()
            return
        except ReportedError as error:
            if isinstance(error, LineRefusedError):
                for unlock in self._activated_by(asked.changes):
                    self.refused[unlock] = str(error)
                    self.objected.add(unlock)
            written = Alarm("lines.not_written", "", {"why": str(error)})
            self.alarm = unknown(error) if self.lost else written
            self.retry_at = self.retry_at if self.lost else asked.at + RETRY_US
        self._fail(asked.changes)

    def retry(self, status: Status, at: int) -> None:
        """Repeat the failed deactivations, and write the last will."""
        part = self.mapping.grips(status, {})
        self._ask(LineWrite(self._undone, self.mapping.last_will(status), part=part), at)
        self.finish()

    def agree(self, at: int, *, gripping: bool = False) -> bool:
        """Return whether the lines are as they were written; raises WireError while that is unknown.

        With ``gripping``, the arbiter must also not have declared this program dead: an abandoned grip must not go on
        by itself, whatever the last will has left active (IL-11).
        """
        self.retry_at = at + RETRY_US
        levels = self._lines.levels()
        self.lost, declared_dead = False, self._lines.declared_dead()
        self.known |= levels
        unknown = sorted(self._written.keys() - levels.keys())
        others = sorted(line for line, level in self._written.items() if levels.get(line, level) != level)
        self.disagreement = ""
        if declared_dead and (others or gripping or unknown):
            self.disagreement = DECLARED_DEAD
        elif others:
            self.disagreement = (
                f"While the line arbiter was lost {', '.join(others)} changed, which this program had not "
                f"commanded; {RESTARTED}"
            )
        elif unknown:
            self.disagreement = (
                f"After the line arbiter was lost the level of {', '.join(unknown)} was unknown; {RESTARTED}"
            )
        return not self.disagreement

    def drive(self, line: str, active: bool, will: tuple[LastWillStep, ...]) -> None:
        """Write one line in maintenance; raises WireError."""
        if self.lost:
            raise ArbiterError(str(self.alarm))
        self._end({line: active}, lambda: self._lines.ask({line: active}, will, drop=not active)())

    def lose(self, error: WireError, at: int) -> None:
        """Note that the line arbiter was lost; nothing is written until `agree` was called."""
        self.lost, self.retry_at = True, at
        self.alarm = unknown(error)

    def let_go(self, lines: Sequence[str], status: Status, at: int) -> None:
        """Deactivate the lines of maintenance; repeated until it succeeds, otherwise the last will does it."""
        self._leased |= set(lines)
        will = (*self.mapping.last_will(status), *maintenance_will(lines))
        self._ask(LineWrite({**self._undone, **dict.fromkeys(lines, False)}, will), at)
        self.finish()

    def _changes(self, wanted: Mapping[str, bool]) -> dict[str, bool]:
        before = self._wanted or {}
        return {line: level for line, level in wanted.items() if before.get(line) != level}

    def _deactivates(self, following: Sequence[Status], status: Status) -> bool:
        """Return whether the next status of the same instant deactivates lines and activates none."""
        return any(
            (changes := self._changes(self.mapping.levels(each))) and not any(changes.values())
            for each in following
            if each.at == status.at
        )

    def _ask(self, write: LineWrite, at: int) -> None:
        changes, will = write.changes, write.will
        if self.lost:
            self._fail(changes)
            return
        try:
            wait = self._lines.ask(changes, will, drop=write.drop, part=write.part)
            self._asked = _Asked(changes, will, at, wait)
        except ReportedError as error:
            self._asked = _Asked(changes, will, at, _nothing, error)

    def _fail(self, changes: Mapping[str, bool]) -> None:
        self._said = None
        if self.lost:
            self._unheard |= {line for line, level in changes.items() if level}
        self._undone = {line: False for line, level in changes.items() if not level}

    def _end(self, changes: Mapping[str, bool], wait: Callable[[], int]) -> int:
        try:
            delay_us = wait()
        except (ArbiterError, LineBusyError):
            # looked at once: perhaps the arbiter is there again
            self.lost, self.retry_at = True, 0
            for line in changes:
                self._written.pop(line, None)  # perhaps it was executed: either level is right
            self.known |= {line: True for line, level in changes.items() if level}
            raise
        self._written |= changes
        self.known |= changes
        self._unheard -= changes.keys()
        self.refused |= dict.fromkeys(self._activated_by(changes), "")
        return delay_us

    def _activated_by(self, changes: Mapping[str, bool]) -> set[bool]:
        """Return the keys of `refused` to which the activated lines belong."""
        return {line == self.mapping.unlock_line for line, level in changes.items() if level}


def unknown(error: ReportedError) -> Alarm:
    """Return the alarm that is shown while the line arbiter is lost."""
    return Alarm(ARBITER_LOST, "", {"why": str(error).rstrip(".")})


def _nothing() -> int:
    """Return 0 at once: there is no reply to wait for."""
    return 0
