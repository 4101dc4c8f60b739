"""Median, 99th percentile, maximum and number of some latencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from statistics import median


@dataclass(frozen=True)
class Figures:
    """In µs; the 99th percentile by nearest rank: with fewer than 100 samples it is the maximum."""

    median: float
    p99: int
    maximum: int
    n: int


def figures(samples: Sequence[int]) -> Figures | None:
    """Of some samples in µs; None of none."""
    if not samples:
        return None
    ordered = sorted(samples)
    return Figures(median(ordered), ordered[ceil(0.99 * len(ordered)) - 1], ordered[-1], len(ordered))
