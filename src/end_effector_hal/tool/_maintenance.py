"""Outputs driven by hand, under a lease (IL-12)."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.wires import WillStep

LEASE_US = 30_000_000


class Maintenance:
    """Which lines are active by hand, and until when; when the lease ends they are deactivated."""

    def __init__(self, description: Description) -> None:
        order = [description.actuators[name].line for name in description.releasing]
        self._order = {line: index for index, line in enumerate(order)}
        self._lines: list[str] = []
        self.ends_at: int | None = None

    @property
    def active(self) -> bool:
        """Whether anything is active by hand."""
        return bool(self._lines)

    @property
    def notice(self) -> str:
        """What to know of it, in words; empty: nothing is driven by hand."""
        return f"Active by hand: {', '.join(self._lines)}; deactivate it first." if self._lines else ""

    def will_with(self, line: str, active: bool) -> tuple[WillStep, ...]:
        """The will once a line is driven so: everything that is active by hand is deactivated."""
        lines = {*self._lines, line} if active else {*self._lines} - {line}
        return tuple(WillStep(each) for each in sorted(lines, key=self._order.__getitem__))

    def drove(self, line: str, active: bool, at: int) -> None:
        """Remember what was driven; the lease starts anew."""
        self._lines = [each for each in self._lines if each != line]
        if active:
            self._lines.append(line)
        self.ends_at = at + LEASE_US if self._lines else None

    def over(self, at: int) -> list[str]:
        """Lines to deactivate because the lease is over; they are forgotten."""
        if self.ends_at is None or at < self.ends_at:
            return []
        lines, self._lines, self.ends_at = sorted(self._lines, key=self._order.__getitem__), [], None
        return lines
