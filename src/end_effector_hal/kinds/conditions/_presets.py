"""Conditions that several kinds share."""

from __future__ import annotations

from typing import Any, Protocol

from end_effector_hal.kinds.stanza import EvidenceConditions, named


class PartSwitches(Protocol):
    """A stanza with a switch that a part turns on, and optionally a switch that is on when the part is gone.

    Attributes:
        part_bit: on: confirmed; off: lost, and also released if nothing else proves a release.
        gone_bit: on, with part_bit off: released; both on: a contradiction.
        confirmed_ms, lost_ms, gone_ms: how long each state must last.
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
    """Return the conditions over the part's switches; None: no switch detects a part."""
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
