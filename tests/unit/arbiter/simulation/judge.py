"""What may never happen, whoever dies when: the judge knows nothing of how the arbiter works."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from end_effector_hal.vocabulary import EndEffectorState

TROUBLES = {"journal", "session record"}
"""Faults that say that faults cannot be kept."""
DOUBTS = ("last wills", "session record")
"""Faults that say that a last will was not, or may not be, executed: the arbiter holds instead."""


class Judge:
    """Is told what happens, and notes what must not."""

    def __init__(self, lines: dict[str, bool], gripping: tuple[str, ...]) -> None:
        self._lines, self._gripping = lines, gripping
        self.violations: list[str] = []
        self.held = False
        self.commanded = False
        """A grip was accepted and goes on: it may activate lines."""
        self.unfinished = False
        """A grip was given up by a death: its lines are to be released before another program comes."""
        self.at_work = True
        """A command has no result yet, or a last will may be at work: lines may go inactive."""
        self.latched: set[str] = set()
        """Faults that somebody was told of, and that nobody has reset."""

    def line(self, name: str, level: bool) -> None:
        """A line is about to be written."""
        if self._lines[name] == level or name not in self._gripping:
            return
        if level and not self.commanded:
            self._violated(f"{name} is activated by itself")
        if not level and self.held:
            self._violated(f"{name} of a held part goes inactive without a Drop")
        if not level and not self.at_work:
            self._violated(f"{name} goes inactive although every command has its result")

    def told(
        self, state: int, waits: Iterable[str] = (), *, held: bool = False, at_work: bool = True
    ) -> None:
        """A program has said its state, and whether it holds; ``waits``: lines that are about to go inactive."""
        self.at_work = at_work
        if held:
            for name in waits:
                self._violated(f"it is told as held while {name} waits to be deactivated")
            self.held = True
        if state != EndEffectorState.GRIPPING:
            self.commanded = False

    def asked(self, levels: Mapping[str, bool], will: Sequence[Mapping[str, object]] | None) -> None:
        """The program writes: what ``deaths.xml`` assumes of it."""
        if not self.held:
            return
        for name in self._gripping:
            if self._lines[name] and not levels.get(name, True):
                self._violated(f"{name} of a held part is asked to be inactive")
        if will:
            self._violated("the last will of a program that holds would release")

    def accepted(self, command: str) -> None:
        """A program has accepted a command."""
        self.held, self.at_work = self.held and command != "drop", True
        self.commanded = command == "grip"

    def unreachable(self, *, held: bool) -> None:
        """A command has ended UNREACHABLE: what was ``held`` before it is held, and nothing is written for it."""
        self.held, self.commanded, self.at_work = held, False, False

    def died(self, state: int) -> None:
        """The program was killed in this state."""
        self.commanded, self.at_work = False, True
        self.unfinished = state == EndEffectorState.GRIPPING and not self.held

    def came(self, faults: set[str]) -> None:
        """Another program writes the lines now; these faults are latched."""
        active = [name for name in self._gripping if self._lines[name]]
        if self.unfinished and active and not faults.intersection(DOUBTS):
            self._violated(
                f"{', '.join(active)} stayed active after a death in the middle of a grip, and nobody says so"
            )
        self.unfinished = self.at_work = False

    def shown(self, faults: set[str], *, safe: set[str]) -> None:
        """The arbiter has told somebody of these faults; those that are ``safe`` stand on the disk."""
        kept = faults
        if "session record" in faults:  # it has said so: only the disk keeps them
            kept = safe
            self.latched &= safe
        if missing := self.latched - faults:
            self._violated(f"the latch of {', '.join(sorted(missing))} is lost")
        self.latched |= (faults & kept) - TROUBLES

    def _violated(self, what: str) -> None:
        self.violations.append(what)
