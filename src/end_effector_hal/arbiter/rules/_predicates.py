"""The last reported predicates, for as long as they are fresh, and the faults that stay until a reset."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple, NoReturn

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
        if not self._names.issuperset(predicates):
            _refuse_unknown(predicates, self._names, "predicate")
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
        if name not in self.client_faults:
            _refuse_unknown([name], self.client_faults, "fault")

    def objections(
        self, needs: Iterable[Need], at: int, *, unlocks: bool = False
    ) -> Iterator[tuple[str, str]]:
        """Yield the interlocks that refuse an activation with these needs now, with their reasons, clauses.

        ``unlocks``: the activation unlocks the tool.
        """
        if STOP in self.faults:
            yield "IL-13", "the tool was stopped; reset the faults first"
        if unlocks and FORMER in self.faults:
            yield "IL-01", self.faults[FORMER].rstrip(".")
        for need in needs:
            proof = self.proofs.get(need.predicate)
            if proof is None or at - proof.at >= self._valid_us:
                yield need.interlock, self._unproven(need, proof, at)
            elif not proof.holds:
                yield need.interlock, need.otherwise
            elif need.latched and need.predicate in self.faults:
                yield need.interlock, f"{need.latched}; reset the faults first"

    def _unproven(self, need: Need, proof: ProvenPredicate | None, at: int) -> str:
        age_us = at - proof.at if proof else 0
        if need.predicate in self._own:
            since = f"for {age_us / 1e6:.3g} s" if proof else "so far"
            why = f" ({self.unread.rstrip('.')})" if self.unread else ""
            return f"{since} the line arbiter could not read whether {need.means}{why}"
        if proof is None:
            return f"no process that reads the sensors has reported yet whether {need.means}"
        if at - self._told_at < self._valid_us and age_us >= SKEW_US:
            return f"the report whether {need.means} was made {age_us / 1e6:.3g} s ago by its stamp; {CLOCKS}"
        return f"for {age_us / 1e6:.3g} s no process that reads the sensors has reported whether {need.means}"

    def reset(self, at: int, of_clients: Iterable[str]) -> list[str]:
        """Clear all faults except ``of_clients`` and those whose predicate is not freshly proven now.

        Returns a sentence for every fault of the second group.
        """
        faults, self.faults = self.faults, {}
        stay = {
            name: f"{interlock}: {why}"
            for name, need in self._latching.items()
            if name in faults
            for interlock, why in self.objections([need], at)
        }
        self.faults = {name: faults[name] for name in (*stay, *of_clients) if name in faults}
        return list(stay.values())


def _refuse_unknown(names: Iterable[str], known: frozenset[str], what: str) -> NoReturn:
    name, has = next(each for each in names if each not in known), ", ".join(sorted(known))
    raise UsageError(
        f"this arbiter has no {what} {name}{hint(name, known)}; it has {has or f'no {what} at all'}."
    )
