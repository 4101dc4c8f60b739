"""The last reported predicates, for as long as they are fresh, and the faults that stay until a reset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from end_effector_hal.arbiter.rules._policy import Need
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import hint

STOP = "stop"
"""Name of the fault that a stop latches; it refuses activations like an open e-stop, also without that input."""

FORMER = "former lines"
"""Name of the fault that a line of an earlier description may be active; it refuses an unlock."""

CLOCKS = "the monotonic clock of that process and of the line arbiter differ: run both in one time namespace"
SKEW_US = 10_000_000
"""Error of a time stamp from which on another clock is assumed as the cause, not a slow machine, µs."""


class ProvenPredicate(NamedTuple):
    """Whether a predicate held at ``at`` µs, as reported by the process that reads the sensors."""

    holds: bool
    at: int


class SensorPredicates:
    """Predicates that expire, and latched faults. Pure: time is an argument, in µs.

    A predicate can refuse activations; it never makes a line inactive. All names are fixed at the start, so no message
    makes a table grow, and faults of clients do not displace those of the arbiter.

    Args:
        needs: the needs of all lines; some of them latch faults.
        valid_us: how long a predicate stays fresh.
        faults: faults from before a restart, sentences by name.
        client_faults: names of the faults that clients may latch.
        own: predicates that the arbiter proves by itself; messages must not name them.
    """

    def __init__(
        self,
        needs: Iterable[Need],
        valid_us: int,
        faults: Mapping[str, str],
        client_faults: Iterable[str] = (),
        own: frozenset[str] = frozenset(),
    ) -> None:
        needs = list(needs)
        self._own = own
        self.unread = ""
        """Why the arbiter's own inputs cannot be read now, a sentence; empty: they are read."""
        self.proofs: dict[str, ProvenPredicate] = {}
        self.faults = dict(faults)
        self._valid_us, self._told_at = valid_us, -SKEW_US
        self._names, self.client_faults = (
            frozenset(need.predicate for need in needs) - own,
            frozenset(client_faults),
        )
        self._latching = {need.predicate: need for need in needs if need.latched}

    def update(self, predicates: Mapping[str, bool], proven_at: int, at: int) -> None:
        """Record predicates that were proven at ``proven_at``; a report older than the recorded one is ignored.

        Raises:
            UsageError: no line needs one of them, or the time is ahead of now; none of them is recorded.
        """
        for name in predicates:
            _check_known(name, self._names, "predicate")
        if proven_at > at:
            raise UsageError(f"at_us is {proven_at - at} µs ahead of now: {CLOCKS}.")
        self._told_at = at
        self._note(predicates, proven_at)

    def read(self, predicates: Mapping[str, bool], read_at: int) -> None:
        """Record the predicates that the arbiter's own inputs prove at ``read_at``."""
        self._note({name: holds for name, holds in predicates.items() if name in self._own}, read_at)

    def _note(self, predicates: Mapping[str, bool], proven_at: int) -> None:
        for name, holds in predicates.items():
            need = self._latching.get(name)
            if need and not holds:  # however old: age makes a proof worthless, not an objection
                self.latch(name, f"{need.interlock}: {need.latched}.")
            known = self.proofs.get(name)
            if not known or known.at <= proven_at:
                self.proofs[name] = ProvenPredicate(holds, proven_at)

    def latch(self, name: str, why: str) -> None:
        """Latch a fault until a reset; if it is latched already, its first reason stays."""
        self.faults.setdefault(name, why)

    def check_client_fault(self, name: str) -> None:
        """Raise UsageError if the policy does not list this fault for clients."""
        _check_known(name, self.client_faults, "fault")

    @property
    def stopped(self) -> str:
        """Why nothing is activated until a reset, a clause; empty: no stop is latched (IL-13)."""
        return "the tool was stopped; reset the faults first" if STOP in self.faults else ""

    def objection(self, need: Need, at: int) -> str:
        """Why an activation with this need is refused, a clause; empty: it is not refused."""
        proof = self.proofs.get(need.predicate)
        if need.predicate in self._own and (proof is None or at - proof.at >= self._valid_us):
            since = f"for {(at - proof.at) / 1e6:.3g} s" if proof else "so far"
            why = f" ({self.unread.rstrip('.')})" if self.unread else ""
            return f"{since} the line arbiter could not read whether {need.means}{why}"
        if proof is None:
            return f"no process that reads the sensors has reported yet whether {need.means}"
        if at - proof.at >= self._valid_us:
            age_s = (at - proof.at) / 1e6
            if at - self._told_at < self._valid_us and at - proof.at >= SKEW_US:
                return f"the report whether {need.means} was made {age_s:.3g} s ago by its stamp; {CLOCKS}"
            return f"for {age_s:.3g} s no process that reads the sensors has reported whether {need.means}"
        if not proof.holds:
            return need.otherwise
        latched = need.latched and need.predicate in self.faults
        return f"{need.latched}; reset the faults first" if latched else ""

    def reset(self, at: int, of_clients: Iterable[str]) -> list[str]:
        """Clear all faults except ``of_clients`` and those whose predicate is not freshly proven now.

        Returns a sentence for every fault of the second group.
        """
        faults, self.faults = self.faults, {}
        stay = {
            name: f"{need.interlock}: {why}"
            for name, need in self._latching.items()
            if name in faults and (why := self.objection(need, at))
        }
        self.faults = {name: faults[name] for name in (*stay, *of_clients) if name in faults}
        return list(stay.values())


def _check_known(name: str, known: frozenset[str], what: str) -> None:
    if name not in known:
        has = ", ".join(sorted(known)) or f"no {what} at all"
        raise UsageError(f"this arbiter has no {what} {name}{hint(name, known)}; it has {has}.")
