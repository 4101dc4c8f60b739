"""Outputs driven by hand, under a lease (IL-12)."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import LastWillStep, display_name, to_us


class Maintenance:
    """Which lines are active by hand, and until when; however it ends, they are deactivated."""

    def __init__(self, description: Description) -> None:
        lines = {name: part.line for name, part in description.ordered}
        self._order = [lines[name] for name in description.releasing]
        self._names = {line: display_name(name) for name, line in lines.items()}
        self._lease_s = description.maintenance.lease_s
        self._lines: set[str] = set()
        self.ends_at: int | None = None

    @property
    def active(self) -> bool:
        """Whether anything is active by hand."""
        return bool(self._lines)

    @property
    def notice(self) -> str:
        """What to know of it, in words; empty: nothing is driven by hand."""
        if not self._lines:
            return ""
        who = ", ".join(self._names[line] for line in self.lines)
        return f"Maintenance: {who} active by hand, deactivated {self._lease_s:g} s after the last call."

    @property
    def lines(self) -> list[str]:
        """What is active by hand, in release order."""
        return [line for line in self._order if line in self._lines]

    @property
    def will(self) -> tuple[LastWillStep, ...]:
        """What is to be done should this program end: everything that is active by hand is deactivated."""
        return _will(self.lines)

    def will_with(self, line: str, active: bool) -> tuple[LastWillStep, ...]:
        """The will once a line is driven so."""
        wanted = self._lines | {line} if active else self._lines - {line}
        return _will([each for each in self._order if each in wanted])

    def drove(self, line: str, active: bool, at: int) -> None:
        """Remember what was driven at ``at`` µs; the lease starts anew."""
        self._lines = self._lines | {line} if active else self._lines - {line}
        self.ends_at = at + to_us(self._lease_s) if self._lines else None

    def over(self, at: int) -> list[str]:
        """Lines to deactivate because the lease is over; they are forgotten."""
        if self.ends_at is None or at < self.ends_at:
            return []
        lines, self._lines, self.ends_at = self.lines, set(), None
        return lines


def _will(lines: list[str]) -> tuple[LastWillStep, ...]:
    return tuple(LastWillStep(line) for line in lines)
