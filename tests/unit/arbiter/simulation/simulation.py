"""Many runs of the arbiter's world, and how often each failure met each message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from tests.unit.arbiter.simulation.world import FAULTS, World, virtual_time

Met = Counter[tuple[str, str]]


def play(
    seeds: Iterable[int], met: Met, most: int = 10, undo: Callable[[Any], None] = lambda _: None
) -> list[tuple[int, str]]:
    """Each seed once; the first violations, with the seed that replays each. ``undo`` patches the product first."""
    violated: list[tuple[int, str]] = []
    with pytest.MonkeyPatch.context() as patch, virtual_time(patch) as enter:
        undo(patch.setattr)
        for seed in seeds:
            world = World(seed, met)
            enter(world)
            world.run()
            violated += [(seed, what) for what in world.judge.violations]
            if len(violated) >= most:
                break
    return violated


def table(met: Met) -> str:
    """A line for each point of a message, a column for each failure."""
    points = sorted({point for _, point in met})
    rows = [["", *FAULTS]] + [
        [point, *(str(met[fault, point] or "") for fault in FAULTS)] for point in points
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if i else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )
