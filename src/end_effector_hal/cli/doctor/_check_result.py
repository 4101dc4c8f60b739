"""The findings of the doctor; one finding is one line."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple


class Level(Enum):
    """Severity of a finding."""

    OK = "ok"
    WARNING = "warning"
    """The tool runs, but perhaps not as well as it could, or not in every way of running it."""
    MISSING = "missing"
    """The tool cannot run in this state."""


class CheckResult(NamedTuple):
    """One finding of the doctor.

    Attributes:
        part: the part of the examination, such as ``lines``.
        level: the severity.
        what: the finding as a sentence.
        todo: the remedy; "" if none is needed.
    """

    part: str
    level: Level
    what: str
    todo: str = ""

    def as_json(self) -> dict[str, str]:
        """Return the finding for ``--json``."""
        return {"part": self.part, "status": self.level.value, "what": self.what, "todo": self.todo}

    @property
    def lines(self) -> list[str]:
        """The finding for people: a line with its severity, and below it the remedy."""
        more = [f"{'':21} → {self.todo}"] if self.todo else []
        return [f"{self.level.value:8} {self.part:12} {self.what}", *more]


CheckResults = Iterator[CheckResult]


class CheckedPart:
    """Makes the findings of one part of the examination."""

    def __init__(self, name: str) -> None:
        self._name = name

    def ok(self, what: str) -> CheckResult:
        """Return a finding that nothing is wrong."""
        return CheckResult(self._name, Level.OK, what)

    def warning(self, what: str, todo: str = "") -> CheckResult:
        """Return a warning; see `Level.WARNING`."""
        return CheckResult(self._name, Level.WARNING, what, todo)

    def missing(self, what: str, todo: str) -> CheckResult:
        """Return a finding that something is missing; see `Level.MISSING`."""
        return CheckResult(self._name, Level.MISSING, what, todo)

    def lacks(self, what: str, todo: str, *, wanted: bool) -> CheckResult:
        """Return a finding of level MISSING if the thing is wanted, as by a variable that is set; else a warning."""
        return self.missing(what, todo) if wanted else self.warning(what, todo)
