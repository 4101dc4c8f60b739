"""What the owner was told of the sensors, for as long as it is fresh, and the faults that stay until a reset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from end_effector_hal.wires.owner._policy import Need

MOST_FAULTS = 32


class Claim(NamedTuple):
    """Somebody who reads the sensors said at ``at`` µs whether a predicate holds."""

    holds: bool
    at: int


class Sensed:
    """Predicates that expire, and latched faults. Pure: time is an argument, in µs.

    A predicate refuses activations; nothing in here ever makes a line inactive.

    Args:
        needs: of all lines; those that latch leave faults.
        valid_us: a predicate is fresh for so long.
        faults: known from before a restart, sentence by name.
    """

    def __init__(self, needs: Iterable[Need], valid_us: int, faults: Mapping[str, str]) -> None:
        self.claims: dict[str, Claim] = {}
        self.faults = dict(faults)
        self._valid_us = valid_us
        self._latching = {need.predicate: need for need in needs if need.latched}

    def tell(self, predicates: Mapping[str, bool], said_at: int, at: int) -> None:
        """Take what was said at ``said_at``; what is older than what is known counts for nothing."""
        said_at = min(said_at, at)
        for name, holds in predicates.items():
            known = self.claims.get(name)
            if known and known.at > said_at:
                continue
            self.claims[name] = Claim(holds, said_at)
            need = self._latching.get(name)
            if need and not holds:
                self.latch(name, f"{need.interlock}: {need.latched}.")

    def latch(self, name: str, why: str) -> None:
        """Keep a fault until a reset; the first reason counts, and no more than 32 are kept."""
        if len(self.faults) < MOST_FAULTS:
            self.faults.setdefault(name, why)

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
