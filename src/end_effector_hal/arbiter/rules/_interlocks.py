"""The checks that refuse the activation of a line: another line, the sensors, a stop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from end_effector_hal.arbiter.rules._lines import OutputLines
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._predicates import SensorPredicates
from end_effector_hal.arbiter.rules._session import Session
from end_effector_hal.errors import LineRefusedError


class LineInterlocks:
    """The interlocks of a policy; time is an argument, in µs.

    Args:
        policy: exclusions, and the predicates that each line needs.
        lines: the lines in their present state.
        predicates: the proven predicates, and whether a stop is latched.
    """

    def __init__(self, policy: Policy, lines: OutputLines, predicates: SensorPredicates) -> None:
        self._policy, self._lines, self._predicates = policy, lines, predicates
        self._partners = {line: policy.partners(line) for line in policy.lines}
        self._unlocking = {
            line for line in policy.lines for other in self._partners[line] if other.interlock == "IL-01"
        }

    def broken(self) -> list[str]:
        """Return lines that are active together with a line that excludes them; possible only at the start."""
        levels = self._lines.levels
        return [
            line
            for line, partners in self._partners.items()
            if levels[line] and any(levels[partner.line] for partner in partners)
        ]

    def check(self, line: str, levels: Mapping[str, bool], sessions: Sequence[Session], at: int) -> None:
        """Check exclusions (IL-01, IL-05, IL-08) and the predicates that the line needs (IL-01, IL-02, IL-05, IL-13).

        Args:
            line: the line to be activated.
            levels: levels in the same write.
            sessions: sessions whose waiting writes count.
            at: the time now.

        Raises:
            LineRefusedError: an interlock refuses; the message begins with its id.
        """
        called = self._policy.called
        for other, interlock, gap_us in self._partners[line]:
            # the same write cannot end one and begin the other: a device may be slower than a line
            active: bool | None = levels.get(other) or self._lines.may_be_active(other)
            for session in sessions:
                for write in session.queue:
                    active = active or write.levels.get(other)
            if active:
                raise LineRefusedError(
                    f"{interlock}: {called(line)} is not activated while {called(other)} is active."
                )
            if at - self._lines.changed_at[other] < gap_us:
                raise LineRefusedError(
                    f"{interlock}: {called(line)} is not activated within {gap_us // 1000} ms after {called(other)}."
                )
        for interlock, why in self.objections(line, at):
            raise LineRefusedError(f"{interlock}: {called(line)} is not activated: {why}.")

    def objections(self, line: str, at: int) -> Iterator[tuple[str, str]]:
        """Return the interlocks that refuse an activation now because of the sensors or a stop, with their reasons."""
        needs = self._policy.needs.get(line, ())
        return self._predicates.objections(needs, at, unlocks=line in self._unlocking)
