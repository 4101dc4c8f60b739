"""Maintenance: services drive single outputs, under a lease (IL-12)."""

from __future__ import annotations

from end_effector_hal.control import maintenance_will
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import LastWill, display_name, to_us


class Maintenance:
    """The lines that maintenance has activated, and the end of its lease; however it ends, they are deactivated."""

    def __init__(self, description: Description) -> None:
        lines = {name: actuator.line for name, actuator in description.ordered}
        self._order = [lines[name] for name in description.releasing]
        self._names = {line: display_name(name) for name, line in lines.items()}
        self._lease_s = description.maintenance.lease_s
        self.lines: list[str] = []
        """The lines that maintenance has activated, in release order."""
        self.ends_at: int | None = None

    @property
    def notice(self) -> str:
        """A sentence for an operator; empty: nothing is active."""
        if not self.lines:
            return ""
        who = ", ".join(self._names[line] for line in self.lines)
        return f"Maintenance: {who} active, deactivated {self._lease_s:g} s after the last call."

    def will_with(self, line: str, active: bool) -> LastWill:
        """Return the last will that applies once ``line`` is driven to ``active``."""
        return maintenance_will(self._with(line, active))

    def drove(self, line: str, active: bool, at: int) -> None:
        """Record the level that a line got at ``at`` µs, and renew the lease."""
        self.lines = self._with(line, active)
        self.ends_at = at + to_us(self._lease_s) if self.lines else None

    def over(self, at: int) -> list[str]:
        """Return the lines to deactivate if the lease is over, and forget them; otherwise an empty list."""
        if self.ends_at is None or at < self.ends_at:
            return []
        lines, self.lines, self.ends_at = self.lines, [], None
        return lines

    def _with(self, line: str, active: bool) -> list[str]:
        wanted = {*self.lines, line} if active else {*self.lines} - {line}
        return [each for each in self._order if each in wanted]
