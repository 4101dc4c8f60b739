"""What is varied: a key of the description, and its values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from itertools import product
from math import prod

from end_effector_hal.errors import UsageError

MOST = 10_000
"""Combinations; each is a proof."""
_TODO = "Write KEY=FROM:TO:STEP or KEY=A,B,C, such as actuators.cylinder.timeout_s=3:7:1."


@dataclass(frozen=True)
class Axis:
    """A key and its values.

    Attributes:
        key: with dots, such as ``actuators.cylinder.timeout_s``.
        values: as they would stand in the file.
    """

    key: str
    values: tuple[str, ...]


def read_axis(text: str) -> Axis:
    """From ``KEY=FROM:TO:STEP``, both ends included, or ``KEY=A,B,C``; raises UsageError."""
    key, equals, given = text.partition("=")
    if not equals or not all(key.split(".")) or not given:
        raise UsageError("This is not a --sweep option.", where=text, todo=_TODO)
    values = _range(text, given) if ":" in given else tuple(each.strip() for each in given.split(","))
    if not all(values) or len(set(values)) < len(values):
        raise UsageError("A --sweep value is empty or repeated.", where=text, todo=_TODO)
    return Axis(key, values)


def combinations(axes: Sequence[Axis]) -> Iterator[dict[str, str]]:
    """Every combination, the last axis first; raises UsageError for a key that stands twice, or too many."""
    keys = [axis.key for axis in axes]
    if len(set(keys)) < len(keys):
        raise UsageError("Two --sweep options name the same key.", where=", ".join(keys))
    if (count := prod(len(axis.values) for axis in axes)) > MOST:
        raise UsageError(f"These are {count} combinations; {MOST} are the most.", todo="Choose larger steps.")
    return (dict(zip(keys, each, strict=True)) for each in product(*(axis.values for axis in axes)))


def _range(text: str, given: str) -> tuple[str, ...]:
    try:
        first, last, step = (Decimal(each) for each in given.split(":"))
        count = int((last - first) / step) + 1 if step > 0 else 0
    except (ValueError, DecimalException, OverflowError):
        raise UsageError("This is not a range of numbers.", where=text, todo=_TODO) from None
    if not 1 <= count <= MOST:
        raise UsageError(f"This range has no value, or more than {MOST}.", where=text, todo=_TODO)
    return tuple(f"{(first + step * number).normalize():f}" for number in range(count))
