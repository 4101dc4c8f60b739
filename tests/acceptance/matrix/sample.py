"""Which cells of `eehal matrix` can be played on real processes, and some of them."""

from __future__ import annotations

from collections import defaultdict
from random import Random

from end_effector_hal.description import Description
from end_effector_lab.matrix import Cell, Moment, cells_of, moments

BETWEEN = ", between"


def playable(description: Description) -> list[tuple[Cell, Moment | None]]:
    """The cells whose moment lies far from any event, each with the event before it; None: it is at rest.

    No process meets a moment to the millisecond, and none is restarted at once.

    Raises:
        UsageError: the tool does not grip without a fault.
    """
    when = moments(description)
    events = {moment.name: moment for moment in when}
    return [
        (cell, events.get(cell.moment.name.removesuffix(BETWEEN)))
        for cell in cells_of(description, when)
        if not cell.at_once and (cell.moment is when[0] or cell.moment.name.endswith(BETWEEN))
    ]


def sample(description: Description, size: int, seed: int) -> list[tuple[Cell, Moment | None]]:
    """So many, each fault as often as any other; the same seed gives the same."""
    random, by_fault = Random(seed), defaultdict(list)
    for cell, event in playable(description):
        by_fault[cell.name].append((cell, event))
    for each in by_fault.values():
        random.shuffle(each)
    names = list(by_fault)
    random.shuffle(names)
    chosen = []
    while len(chosen) < size and any(by_fault.values()):
        for name in names:
            if by_fault[name] and len(chosen) < size:
                chosen.append(by_fault[name].pop())
    return chosen
