"""Check that the written lines and last wills are those that the decisions request.

There is no separate record of an executed last will: its effect shows in the levels that the program finds when it
restarts. They are checked against the last will that was written before.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from typing import NamedTuple

from end_effector_hal.control import Status, changer_will, maintenance_will
from end_effector_hal.description import Description
from end_effector_hal.runtime.boundary import LinesWritten, Start
from end_effector_hal.runtime.outputs import Maintenance, OutputMapping
from end_effector_hal.vocabulary import EndEffectorState, LastWill, display_name
from timed_automata.monitor import Objection

Level = tuple[str, bool]
Steps = tuple[tuple[object, ...], ...]
"""A last will: line, level and µs after the death for each step."""


class _Decision(NamedTuple):
    """A status: the levels that it changes, its last will, and the last will for an end in good order.

    ``excused``: it may be unwritten, because the line arbiter was lost.
    """

    changes: set[Level]
    will: Steps
    parting: Steps
    excused: bool = False


class WrittenLines:
    """Compares the recorded writes of the program with its recorded statuses.

    A write changes the lines from one status to a later one, and sets the last will of that status. In addition it may
    contain only changes that an earlier write owed, because it failed or the line arbiter was lost, and lines that
    maintenance drives in STAND_BY.

    Args:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self._description, self._mapping = description, OutputMapping(description, Maintenance(description))
        self._names = {actuator.line: display_name(name) for name, actuator in description.ordered}
        self._maintained = frozenset(self._names)
        self._release_order = [description.actuators[name].line for name in description.releasing]
        changer = description.tool_changer
        limited = {each.line for each in description.blow_offs.values()} | (
            {changer.line} if changer else set()
        )
        # the arbiter ends them by itself, or nobody knows how they stand
        self._unsure = limited | description.may_be_unknown
        self._last: Status | None = None
        self._levels: Mapping[str, bool] | None = None
        self._decided: list[_Decision] = []
        self._changed = self._anchored = self._lost = False
        self._owed: set[Level] = set()
        self._driven: set[str] = set()
        self._doubtful: set[str] = set()
        self._possible: dict[str, set[bool]] = {}
        self._wills: list[Steps] = []

    def copied(self) -> WrittenLines:
        """Return an independent copy."""
        other = copy(self)
        other._decided, other._wills = [*self._decided], [*self._wills]
        other._owed, other._driven = {*self._owed}, {*self._driven}
        other._doubtful = {*self._doubtful}
        other._possible = {line: {*levels} for line, levels in self._possible.items()}
        return other

    def begin(self, start: Start) -> Iterator[Objection]:
        """Process a start or restart of the program, whose first status writes all lines.

        At a restart, the levels must be those that the program has written, or that its last will has left.
        """
        yield from self._after_death(start)
        self._levels, self._decided = {}, []
        self._changed = self._anchored = True
        self._lost = False
        self._owed.clear()
        self._driven.clear()
        self._doubtful.clear()
        self._possible = {line: {level} for line, level in start.levels.items() if line in self._names}
        self._wills = []

    def status(self, status: Status) -> None:
        """Process a decided status."""
        if not status.adopted:
            return
        levels, before = self._mapping.levels(status), self._levels
        self._last, self._levels = status, levels
        changes = set[Level]()
        if before is not None:  # what a segment begins with stands in the one before it
            changes = {(line, level) for line, level in levels.items() if before.get(line) is not level}
        self._changed |= bool(changes)
        will, parting = (_steps(self._mapping.last_will(status, on)) for on in ("process_death", "sigterm"))
        decision = _Decision(changes, will, parting, excused=self._lost)
        if not changes and self._decided and self._decided[-1][1:] == decision[1:]:
            return
        self._decided.append(decision)

    def lines(self, record: LinesWritten, *, final: bool = False) -> Iterator[Objection]:
        """Process a write; yield an objection to each level, and to a last will, that no decision requests.

        Args:
            record: the write.
            final: whether it is the last write of the trace: the program may have ended with its declared last will.
        """
        written, will = set(record.levels.items()), tuple(map(_step, record.will))
        if self._changed:
            yield from self._objections(record, written, will, final=final)
        if record.error:
            self._owed |= written
            for line, level in written:
                self._possible.setdefault(line, {False, True}).add(level)
            self._wills.append(will)
            self._doubtful |= self._driven & record.levels.keys()
            self.lose()
        else:
            self._owed -= written | {(line, not level) for line, level in written}
            self._possible |= {line: {level} for line, level in written}
            self._wills = [will]
            self._lost = False

    def lose(self) -> None:
        """Process a loss of the line arbiter: decisions made meanwhile are not written."""
        self._lost = True
        self._decided = [each._replace(excused=True) for each in self._decided]

    def _objections(
        self, record: LinesWritten, written: set[Level], will: Steps, *, final: bool
    ) -> Iterator[Objection]:
        driven, waits = set(self._driven), any(each.changes for each in self._decided)
        maintained = set() if waits else self._by_maintenance(written)
        rest = written - self._owed - maintained
        place = next(
            (n for n, each in enumerate(self._decided) if each.changes and each.changes <= written), None
        )
        if place is not None:
            skipped, matched = self._decided[:place], self._decided[place]
            rest -= matched.changes
            self._owed |= set().union(*(each.changes for each in skipped))
            self._decided[: place + 1] = [matched._replace(changes=set())]
            self._anchored = True
            missing = set().union(*(each.changes for each in skipped if not each.excused)) - written
            for line, level in sorted(missing):
                what = f"{self._called(line)} should have been {_word(level)}, but that was not written."
                yield Objection(record.at, "no run", what)
        meant = self._decided if written or final else self._before_next_change()
        for line, level in sorted(rest):
            yield Objection(
                record.at, "no run", f"{self._called(line)} was {_word(level)}, and no decision asks for it."
            )
        expected: list[Steps] = [each.will for each in meant] if meant or waits else [()]
        if final and not written:
            expected += [each.parting for each in meant]
        if driven or maintained:
            expected = self._in_maintenance(driven, maintained, expected)
        if will not in expected and self._anchored:
            said = ", then ".join(f"{step[0]} after {step[2]} µs" for step in will) or "nothing"
            what = f"The last will that was left deactivates {said[:200]}, and no decision asks for that."
            yield Objection(record.at, "no run", what)
        elif not written:
            self._pass_over(will)

    def _before_next_change(self) -> list[_Decision]:
        """Return the decisions before the next change of a line; a write of only a last will belongs to one of them."""
        changing = (n for n, each in enumerate(self._decided) if each.changes and not each.excused)
        return self._decided[: next(changing, None)]

    def _in_maintenance(
        self, driven: set[str], maintained: set[Level], otherwise: list[Steps]
    ) -> list[Steps]:
        """Return the allowed last wills for a write by maintenance, or while maintenance has activated lines."""
        begins = any(level for _, level in maintained)
        some = [self._driven] if begins or not maintained else [driven, self._driven]
        found: list[Steps] = []
        for lines in (each - less for each in some for less in (set[str](), self._doubtful)):
            found += [self._maintenance(lines)] if lines or maintained else otherwise
        return found

    def _pass_over(self, will: Steps) -> None:
        """After a write of only a last will, remove the earlier decisions that change no line."""
        number = next((n for n, each in enumerate(self._decided) if each.will == will), 0)
        self._decided = [each for each in self._decided[:number] if each.changes] + self._decided[number:]

    def _by_maintenance(self, written: set[Level]) -> set[Level]:
        ended = {(line, False) for line in self._driven if (line, False) in written}
        self._driven -= {line for line, _ in ended}
        if self._last is None or self._last.ee != EndEffectorState.STAND_BY:
            return ended
        begun = {(line, True) for line in self._maintained if (line, True) in written}
        self._driven |= {line for line, _ in begun}
        return ended | begun

    def _called(self, line: str) -> str:
        return f"{self._names.get(line, line)} ({line})"

    def _maintenance(self, driven: set[str]) -> Steps:
        unlocking = changer_will(self._description, self._last) if self._last is not None else ()
        return _steps((*unlocking, *maintenance_will(line for line in self._release_order if line in driven)))

    def _after_death(self, start: Start) -> Iterator[Objection]:
        """Yield objections if the levels found at a start are not those that the last will should have left."""
        sure = {
            line: next(iter(levels))
            for line, levels in self._possible.items()
            if len(levels) == 1 and line not in self._unsure
        }
        for line in sorted(sure.keys() - start.levels.keys()):
            del sure[line]
            what = f"{self._called(line)} was written before, but is not among the lines that were found."
            yield Objection(start.at, "no run", what)
        for line, level in sure.items():
            if start.levels[line] and not level:
                what = f"{self._called(line)} was found active, and nothing had activated it."
                yield Objection(start.at, "no run", what)
        fallen = {line for line, level in sure.items() if level and not start.levels[line]}
        stayed = {line for line, level in sure.items() if level and start.levels[line]}
        if fallen and not any(_executed(will, fallen, stayed) for will in self._wills):
            who = ", ".join(sorted(self._names.get(line, line) for line in fallen))
            left = ", ".join(sorted(self._names.get(line, line) for line in stayed)) or "nothing"
            what = (
                f"{who} was found inactive and {left} active: the last will that was left does not do that."
            )
            yield Objection(start.at, "no run", what)


def _word(level: bool) -> str:
    return "activated" if level else "deactivated"


def _executed(will: Steps, fallen: set[str], stayed: set[str]) -> bool:
    """Return whether a completely executed last will explains the levels; a restarting program waits for its end."""
    lines = {step[0] for step in will}
    return fallen <= lines and not stayed & lines


def _steps(will: LastWill) -> Steps:
    return tuple((step.line, step.level, step.after_us) for step in will)


def _step(recorded: Mapping[str, object]) -> tuple[object, ...]:
    """Return a recorded step; invalid content becomes a value that equals no step."""
    step = recorded.get("line"), recorded.get("level"), recorded.get("after_us")
    known = (
        recorded.keys() == {"line", "level", "after_us"}
        and isinstance(step[0], str)
        and isinstance(step[1], bool)
    )
    return step if known and type(step[2]) is int else (str(dict(recorded)), None, None)
