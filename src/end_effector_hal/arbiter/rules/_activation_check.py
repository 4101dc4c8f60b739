"""Whether a line may be activated now."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from end_effector_hal.arbiter.rules._lines import OutputLines
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._predicates import SensorPredicates
from end_effector_hal.arbiter.rules._session import Session
from end_effector_hal.errors import LineRefusedError


class ActivationCheck:
    """Exclusions between lines (IL-01, IL-05, IL-08), and what the sensors must prove (IL-01, IL-02, IL-05, IL-13).

    Args:
        policy: which lines exclude or need what.
        lines: their levels.
        predicates: what the sensors prove.
    """

    def __init__(self, policy: Policy, lines: OutputLines, predicates: SensorPredicates) -> None:
        self._policy, self._lines, self._predicates = policy, lines, predicates

    def check_activation(
        self, line: str, levels: Mapping[str, bool], sessions: Iterable[Session], at: int
    ) -> None:
        """Check one line of a write.

        Args:
            line: to be activated.
            levels: the whole write.
            sessions: of all clients; what waits in their queues counts as active.
            at: now, µs.

        Raises:
            LineRefusedError: an interlock refuses; its id stands first.
        """
        called = self._policy.called(line)
        for other, interlock, gap_us in self._policy.partners(line):
            if levels.get(other, self._may_be_active(other, sessions)):
                raise LineRefusedError(
                    f"{interlock}: {called} is not activated while {self._policy.called(other)} is active."
                )
            if at - self._lines.changed_at[other] < gap_us:
                raise LineRefusedError(
                    f"{interlock}: {called} is not activated within {gap_us // 1000} ms after "
                    f"{self._policy.called(other)}."
                )
        for need in self._policy.needs.get(line, ()):
            if why := self._predicates.objection(need, at):
                raise LineRefusedError(f"{need.interlock}: {called} is not activated: {why}.")

    def _may_be_active(self, line: str, sessions: Iterable[Session]) -> bool:
        """Whether it is active now, or will be before everything that waits is applied."""
        return self._lines.levels[line] or any(
            write.levels.get(line) for session in sessions for write in session.queue
        )
