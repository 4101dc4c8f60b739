"""Errors of the automata: what happened, where, and what to do. Every error has a stable code and an exit code."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Diagnostic:
    """One fault in the form that every command prints; ``line`` and ``column`` are 0 if the fault has no position."""

    code: str
    file: str
    line: int
    column: int
    message: str

    @classmethod
    def at(cls, code: str, where: str, message: str) -> Diagnostic:
        """Return a fault at ``file:line:column``, or at another place that ``where`` names."""
        file, *numbers = where.rsplit(":", 2)
        if len(numbers) == 2 and all(each.isdigit() for each in numbers):
            return cls(code, file, int(numbers[0]), int(numbers[1]), message)
        return cls(code, where, 0, 0, message)

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        return f"{place}: {self.message} [{self.code}]" if place else f"{self.message} [{self.code}]"

    def as_json(self) -> dict[str, object]:
        """Return the fault as a dictionary for ``--json``."""
        return asdict(self)


class ReportedError(Exception):
    """Base class of all refusals and failures: what happened, where, and what to do.

    Args:
        what: one sentence that says what happened.
        where: ``file:line:column``, a line name, a port, …
        todo: what the reader can do about it.
    """

    code = "EE-000"
    exit_code = 1

    def __init__(self, what: str, *, where: str = "", todo: str = "") -> None:
        self.what, self.where, self.todo = what, where, todo
        super().__init__(what)

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        advice = f" {self.todo}" if self.todo else ""
        return f"{place}{self.what}{advice}"

    @property
    def sentence(self) -> str:
        """The whole message for a person; it begins with a capital letter unless it begins with a place."""
        text, placed = str(self), any(each.file for each in self.diagnostics)
        return text if placed or not re.match(r"[a-z]+ ", text) else text[0].upper() + text[1:]

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The faults of this error as a tuple."""
        return (Diagnostic.at(self.code, self.where, f"{self.what} {self.todo}".strip()),)


class UsageError(ReportedError, ValueError):
    """A command received an argument or input that it cannot use."""

    code = "EE-100"
    exit_code = 2


class ModelError(ReportedError, ValueError):
    """The UPPAAL file is not valid, or uses something outside of the supported subset."""

    code = "EE-300"
    exit_code = 2


class RangeError(ModelError):
    """An assignment, an index or a division left its range while the network ran: the model has a fault."""

    code = "EE-301"


class StoppedError(ReportedError):
    """An exploration was stopped by its progress callback before its end; its question is not decided."""

    code = "EE-302"
    exit_code = 4
