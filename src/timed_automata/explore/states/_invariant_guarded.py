"""Symbolic states without the deadlocks that widening makes up.

ExtraLU+ lets zones grow past invariants, by valuations that only behave like others as far as transitions go: some are
deadlocked and vector for none that is. Here a transition starts inside the invariant of its source, and zones are
widened only where time passes: a chain of committed locations is too short to need it.
"""

from __future__ import annotations

from timed_automata.explore.states._firing import Action
from timed_automata.explore.states._symbolic import Form, StateRecord, SymbolicSpace
from timed_automata.explore.zones import Constraint


class InvariantGuardedSpace(SymbolicSpace):
    """For an exploration that looks for deadlocks among zones widened by ExtraLU+."""

    def guard(self, source: StateRecord, action: Action) -> tuple[Constraint, ...]:
        """What the zones of a record must satisfy for a move: the invariant, too."""
        return (*super().guard(source, action), *source.invariant)

    def widens_in(self, form: Form) -> bool:
        """Where time passes."""
        return form.delays
