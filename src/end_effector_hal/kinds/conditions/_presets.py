"""Conditions that several kinds have in common."""

from __future__ import annotations

from typing import Any

from end_effector_hal.kinds.stanza import EvidenceConditions, named


def part_conditions(
    part_bit: str | None, gone_bit: str | None, *, confirmed_ms: int, lost_ms: int, gone_ms: int
) -> EvidenceConditions | None:
    """By a switch that a part makes, and maybe one that shows that it is gone; None: there is no such switch.

    Args:
        part_bit: makes it confirmed; off, it is lost, and released where nothing else proves that.
        gone_bit: on, with part_bit off, proves that it is released; both on contradict each other.
        confirmed_ms, lost_ms, gone_ms: so long each must stand.
    """
    part, gone = named(part_bit), named(gone_bit)
    if part is None:
        return None
    there: dict[str, Any] = {"on": part}
    away: dict[str, Any] = {"not": there} if gone is None else {"all": [{"on": gone}, {"not": there}]}
    return EvidenceConditions.model_validate(
        {
            "confirmed": {**there, "for_ms": confirmed_ms},
            "lost": {"not": there, "for_ms": lost_ms},
            "gone": {**away, "for_ms": gone_ms},
        }
    )
