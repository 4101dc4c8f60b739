"""The table of a sweep."""

from __future__ import annotations

from collections.abc import Sequence

from ._axis import Axis
from ._sweep import Proven

REFUSED = "refused"


def table(axes: Sequence[Axis], found: Sequence[Proven]) -> list[list[str]]:
    """Return rows with a head: the values, the verdict, the first failure, the worst cases in seconds."""
    names = [*dict.fromkeys(name for each in found for name in each.worst)]
    rows = [[*(axis.key for axis in axes), "verdict", "fails first", *names]]
    for each in found:
        worst = [_seconds(each.worst.get(name)) for name in names]
        rows.append([*each.values.values(), verdict(each), _first(each), *worst])
    return rows


def verdict(each: Proven) -> str:
    """Return one word: refused, fails, holds or open."""
    if each.refused:
        return REFUSED
    return "fails" if each.fails else "holds" if each.holds else "open"


def _first(each: Proven) -> str:
    return each.fails[0] if each.fails else each.refused


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:g}"
