"""Maintenance: services drive single outputs, under a lease (IL-12)."""

from __future__ import annotations

from end_effector_hal.control import maintenance_will
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import LastWill, display_name, to_us


class Maintenance:
    """The lines that maintenance has activated, and the end of its lease; however it ends, they are deactivated."""

    def __init__(self, description: Description) -> None:
        lines = {name: part.line for name, part in description.ordered}
        self._order = [lines[name] for name in description.releasing]
        self._names = {line: display_name(name) for name, line in lines.items()}
        self._lease_s = description.maintenance.lease_s
        self._lines: set[str] = set()
        self.ends_at: int | None = None

    @property
    def active(self) -> bool:
        """Whether maintenance has activated anything."""
        return bool(self._lines)

    @property
    def notice(self) -> str:
        """A sentence for an operator; empty: nothing is active."""
        if not self._lines:
            return ""
        who = ", ".join(self._names[line] for line in self.lines)
        return f"Maintenance: {who} active, deactivated {self._lease_s:g} s after the last call."

    @property
    def lines(self) -> list[str]:
        """The lines that maintenance has activated, in release order."""
        return [line for line in self._order if line in self._lines]

    @property
    def will(self) -> LastWill:
        """The last will while maintenance has activated lines; empty otherwise."""
        return maintenance_will(self.lines) if self._lines else ()

    def will_with(self, line: str, active: bool) -> LastWill:
        """Return the last will that applies once ``line`` is driven to ``active``."""
        wanted = self._lines | {line} if active else self._lines - {line}
        return maintenance_will(each for each in self._order if each in wanted)

    def drove(self, line: str, active: bool, at: int) -> None:
        """Record the level that a line got at ``at`` µs, and renew the lease."""
        self._lines = self._lines | {line} if active else self._lines - {line}
        self.ends_at = at + to_us(self._lease_s) if self._lines else None

    def over(self, at: int) -> list[str]:
        """Return the lines to deactivate if the lease is over, and forget them; otherwise an empty list."""
        if self.ends_at is None or at < self.ends_at:
            return []
        lines, self._lines, self.ends_at = self.lines, set(), None
        return lines
