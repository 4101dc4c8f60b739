"""What the doctor says: one finding per line."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple


class Level(Enum):
    """How bad it is."""

    OK = "ok"
    WARNING = "warning"
    """The tool runs, perhaps not as well as it could; or it is not needed for every way to run it."""
    MISSING = "missing"
    """The tool does not run like this."""


class CheckResult(NamedTuple):
    """One thing that was looked at.

    Attributes:
        part: which part of the examination, such as ``lines``.
        level: how it is.
        what: a sentence.
        todo: what to do about it; "" if nothing.
    """

    part: str
    level: Level
    what: str
    todo: str = ""

    def as_json(self) -> dict[str, str]:
        """For ``--json``."""
        return {"part": self.part, "status": self.level.value, "what": self.what, "todo": self.todo}

    @property
    def lines(self) -> list[str]:
        """For people: how it is, and below it what to do."""
        more = [f"{'':21} → {self.todo}"] if self.todo else []
        return [f"{self.level.value:8} {self.part:12} {self.what}", *more]


CheckResults = Iterator[CheckResult]


class CheckedPart:
    """Makes the findings of one part."""

    def __init__(self, name: str) -> None:
        self._name = name

    def ok(self, what: str) -> CheckResult:
        """As it should be."""
        return CheckResult(self._name, Level.OK, what)

    def warning(self, what: str, todo: str = "") -> CheckResult:
        """See `Level.WARNING`."""
        return CheckResult(self._name, Level.WARNING, what, todo)

    def missing(self, what: str, todo: str) -> CheckResult:
        """See `Level.MISSING`."""
        return CheckResult(self._name, Level.MISSING, what, todo)

    def lacks(self, what: str, todo: str, *, wanted: bool) -> CheckResult:
        """Missing where it is wanted, as by a variable that is set; else a warning."""
        return self.missing(what, todo) if wanted else self.warning(what, todo)
