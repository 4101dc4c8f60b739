"""Computes median, 99th percentile, maximum and number of latencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from statistics import median


@dataclass(frozen=True)
class Figures:
    """Statistics in µs; the 99th percentile by nearest rank: with fewer than 100 samples it is the maximum."""

    median: float
    p99: int
    maximum: int
    n: int


def figures(samples: Sequence[int]) -> Figures | None:
    """Return the statistics of samples in µs; None if there are none."""
    if not samples:
        return None
    ordered = sorted(samples)
    return Figures(median(ordered), ordered[ceil(0.99 * len(ordered)) - 1], ordered[-1], len(ordered))
