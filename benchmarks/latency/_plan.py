"""How much is measured."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Plan:
    """Counts of one phase.

    Attributes:
        blocks: pairs of product and floor.
        cycles: grips and drops in a block; each gives 4 reactions, 2 commands, 6 states.
        floor_s: length of a block of the floor, which makes 5 reactions and 5 commands a second.
        losses: how many times a held part is lost.
        hold_s: how long processor time and memory are measured while gripped.
    """

    blocks: int
    cycles: int
    floor_s: float
    hold_s: float
    losses: int


FULL = Plan(blocks=8, cycles=4, floor_s=5.0, hold_s=20.0, losses=20)
QUICK = Plan(blocks=2, cycles=2, floor_s=3.0, hold_s=5.0, losses=5)
