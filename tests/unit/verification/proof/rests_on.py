"""What of the proof rests on the reaction bound D: the table of ``verification.md``, computed.

``python -m tests.unit.verification.proof.rests_on`` proves the shipped tool with other values of it, everything
else as it is, halves the intervals in which a requirement stops to hold, and prints the table: a few minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.proof import requirements_of
from timed_automata import load_network
from timed_automata.explore import overview

Failing = Callable[[int], frozenset[str]]


class Assumption(NamedTuple):
    """A constant that the proof rests on, in ms: as the docs call it, and the values that are tried."""

    constant: str
    words: str
    tried: tuple[int, ...]


ASSUMED = (Assumption("D", "reaction bound D", (1, 10, 50, 100, 200, 500, 1000)),)


@cache
def failing(constant: str, ms: int) -> frozenset[str]:
    """The requirements, and what no query says, that do not hold of the shipped tool with another value."""
    tool = load(profile_path())
    network = load_network(tool.automata_path, model_constants(tool) | {constant: ms})
    requirements = requirements_of(network)
    found = overview(network, [each.query for each in requirements])
    checks = {
        "locations": found.coverage.locations,
        "edges": found.coverage.edges,
        "channels": found.open_channels,
        "time": found.stopped or found.zeno,
    }
    named = {each.id for each, holds in zip(requirements, found.answers, strict=True) if not holds}
    return frozenset(named | {id_ for id_, fault in checks.items() if fault})


def first_failing(tried: Sequence[int], fails: Failing) -> dict[str, int]:
    """By requirement the smallest value with which it does not hold, between values that were tried.

    One that fails with the smallest value already is told with that.
    """
    found: dict[str, int] = {}
    for ms, before in zip(tried, (None, *tried), strict=False):
        for id_ in fails(ms) - found.keys():
            found[id_] = ms if before is None else _halved(id_, before, ms, fails)
    return found


def _halved(id_: str, holds: int, does_not: int, fails: Failing) -> int:
    while does_not - holds > 1:
        middle = (holds + does_not) // 2
        if id_ in fails(middle):
            does_not = middle
        else:
            holds = middle
    return does_not


def row(assumed: Assumption, found: dict[str, int]) -> str:
    """A line of the table."""
    by_value = sorted({value: [i for i in found if found[i] == value] for value in found.values()}.items())
    ends = [f"{', '.join(f'`{id_}`' for id_ in sorted(ids))} from {value} ms on" for value, ids in by_value]
    shipped = model_constants(load(profile_path()))[assumed.constant]
    spread = f"{assumed.tried[0]} ms to {assumed.tried[-1] / 1000:g} s"
    return f"| {assumed.words} | {shipped} ms | {spread} | {'; '.join(ends) or 'nothing'} |"


def table() -> Iterator[str]:
    """The lines of the table, one for each assumption."""
    for assumed in ASSUMED:
        yield row(assumed, first_failing(assumed.tried, lambda ms, it=assumed: failing(it.constant, ms)))  # type: ignore[misc]


if __name__ == "__main__":
    for line in table():
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
