"""Conditions that several kinds have in common."""

from __future__ import annotations

from typing import Any, Protocol

from end_effector_hal.kinds.stanza import EvidenceConditions, named


class PartSwitches(Protocol):
    """A stanza with a switch that a part makes, and maybe one that shows that it is gone.

    Attributes:
        part_bit: makes it confirmed; off, it is lost, and released where nothing else proves that.
        gone_bit: on, with part_bit off, proves that it is released; both on contradict each other.
        confirmed_ms, lost_ms, gone_ms: so long each must stand.
    """

    @property
    def part_bit(self) -> str | None: ...

    @property
    def gone_bit(self) -> str | None: ...

    @property
    def confirmed_ms(self) -> int: ...

    @property
    def lost_ms(self) -> int: ...

    @property
    def gone_ms(self) -> int: ...


def part_conditions(switches: PartSwitches) -> EvidenceConditions | None:
    """By its switches; None: it has none that a part makes."""
    part, gone = named(switches.part_bit), named(switches.gone_bit)
    if part is None:
        return None
    there: dict[str, Any] = {"on": part}
    away: dict[str, Any] = {"not": there} if gone is None else {"all": [{"on": gone}, {"not": there}]}
    return EvidenceConditions.model_validate(
        {
            "confirmed": {**there, "for_ms": switches.confirmed_ms},
            "lost": {"not": there, "for_ms": switches.lost_ms},
            "gone": {**away, "for_ms": switches.gone_ms},
        }
    )
