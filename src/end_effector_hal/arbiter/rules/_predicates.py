"""What the owner was told of the sensors, for as long as it is fresh, and the faults that stay until a reset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import NamedTuple

from end_effector_hal.arbiter.rules._policy import Need
from end_effector_hal.errors import UsageError


class Claim(NamedTuple):
    """Who reads the sensors said at ``at`` µs whether a predicate holds."""

    holds: bool
    at: int


class SensorPredicates:
    """Predicates that expire, and latched faults. Pure: time is an argument, in µs.

    A predicate refuses activations; nothing in here ever makes a line inactive. All names are known beforehand: no
    message makes a table grow, and no fault of a client takes the room of one that the owner latches.

    Args:
        needs: of all lines; those that latch leave faults.
        valid_us: a predicate is fresh for so long.
        faults: known from before a restart, sentence by name.
        kept: names of the faults that clients may have kept.
    """

    def __init__(
        self, needs: Iterable[Need], valid_us: int, faults: Mapping[str, str], kept: Iterable[str] = ()
    ) -> None:
        needs = list(needs)
        self.claims: dict[str, Claim] = {}
        self.faults = dict(faults)
        self._valid_us = valid_us
        self._names, self._kept = frozenset(need.predicate for need in needs), frozenset(kept)
        self._latching = {need.predicate: need for need in needs if need.latched}

    def tell(self, predicates: Mapping[str, bool], said_at: int, at: int) -> None:
        """Take what was said at ``said_at``; what is older than what is known counts for nothing.

        Raises:
            UsageError: no line needs one of them, or it is said of a time ahead of now; nothing of it counts.
        """
        for name in predicates:
            _check_known(name, self._names, "predicate")
        if said_at > at:
            raise UsageError(f"at_us is {said_at - at} µs ahead of now.")
        for name, holds in predicates.items():
            known = self.claims.get(name)
            if known and known.at > said_at:
                continue
            self.claims[name] = Claim(holds, said_at)
            need = self._latching.get(name)
            if need and not holds:
                self.latch(name, f"{need.interlock}: {need.latched}.")

    def latch(self, name: str, why: str) -> None:
        """Keep a fault that the owner has seen itself until a reset; the first reason counts."""
        self.faults.setdefault(name, why)

    def keep(self, name: str, why: str) -> None:
        """Keep a fault for a client.

        Raises:
            UsageError: the policy lists no such fault.
        """
        _check_known(name, self._kept, "fault")
        self.latch(name, why)

    def objection(self, need: Need, at: int) -> str:
        """Why an activation that needs this is refused, as a sentence without its subject; empty: it is not."""
        claim = self.claims.get(need.predicate)
        if claim is None:
            return f"nobody who reads the sensors has said yet whether {need.means}"
        if at - claim.at >= self._valid_us:
            return f"for {(at - claim.at) / 1e6:.3g} s nobody who reads the sensors has said whether {need.means}"
        if not claim.holds:
            return need.otherwise
        latched = need.latched and need.predicate in self.faults
        return f"{need.latched}; reset the faults first" if latched else ""

    def reset(self, at: int) -> list[str]:
        """Clear the faults; those whose predicate does not hold now, freshly, stay, and are returned in words."""
        faults, self.faults = self.faults, {}
        stay = {
            name: why
            for name, need in self._latching.items()
            if name in faults and (why := self.objection(need, at))
        }
        self.faults = {name: faults[name] for name in stay}
        return [f"{self._latching[name].interlock}: {why}" for name, why in stay.items()]


def _check_known(name: str, known: frozenset[str], what: str) -> None:
    if name not in known:
        close = get_close_matches(name, known, n=1)
        hint = f" (did you mean {close[0]}?)" if close else ""
        has = ", ".join(sorted(known)) or f"no {what} at all"
        raise UsageError(f"this owner knows no {what} {name}{hint}; it knows {has}.")
