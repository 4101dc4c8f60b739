"""Symbolic states without the deadlocks that widening makes up.

ExtraLU+ lets zones grow past invariants, by valuations that only behave like others as far as transitions go: some are
deadlocked and stand for none that is. Here a transition starts inside the invariant of its source, and zones are
widened only where time passes: a chain of committed locations is too short to need it.
"""

from __future__ import annotations

from end_effector_hal.automata.explore._discrete import Move
from end_effector_hal.automata.explore._plan import Plan
from end_effector_hal.automata.explore._symbolic import Place, SymbolicSpace
from end_effector_hal.automata.explore._zone import Constraint


class SharpSpace(SymbolicSpace):
    """For an exploration that looks for deadlocks among zones widened by ExtraLU+."""

    def guard(self, source: Place, move: Move) -> tuple[Constraint, ...]:
        """What the zones of a place must satisfy for a move: the invariant, too."""
        return (*super().guard(source, move), *source.invariant)

    def _plan(
        self, n: int, guard: tuple[Constraint, ...], sources: tuple[tuple[int, int], ...], target: Place
    ) -> Plan:
        delays = target.discrete.delays
        key = (n, guard, sources, delays, target.invariant, id(target.shape.widening) if delays else None)
        plan = self._plans.get(key)
        if plan is None:
            limits = target.shape.widening if delays else None
            plan = Plan(n, guard, sources, delays, target.invariant, limits, self._unique)
            self._plans[key] = plan
        return plan
