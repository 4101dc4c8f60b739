"""Measured values over a long time in a bounded number of samples that preserve spikes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from end_effector_hal.page.view import Curve

SPIKE = 0.01
"""Share of the scale; a smaller move within one step is drawn as one sample."""


class Samples:
    """Keeps the newest row of each step; if a value moved within the step, also its minimum and its maximum.

    Args:
        curves: the curves that are drawn.
        epoch: time zero, µs.
        step_us: length of a step.
    """

    def __init__(self, curves: Sequence[Curve], epoch: int, step_us: int) -> None:
        self._epoch, self._step_us = epoch, step_us
        self._spikes = [(curve.most - curve.low) * SPIKE for curve in curves]
        self._decimals = [curve.decimals for curve in curves]
        self._begun: int | None = None
        self._rows: list[list[Any]] = []
        self.columns: list[list[Any]] = [[] for _ in range(1 + len(curves))]
        """Times in ms since time zero, then the values of each curve; None: no valid reading."""

    def take(self, row: list[Any]) -> None:
        """Add a row of the timeline: a time in µs, then values."""
        if self._begun is None:
            self._begun = row[0]
        elif row[0] - self._begun >= self._step_us:
            self.flush()
            self._begun = row[0]
        self._rows.append(row)

    def flush(self) -> None:
        """Write the samples of the step that has ended."""
        rows, self._rows = self._rows, []
        if not rows:
            return
        ranges = [[row[index] for row in rows if row[index] is not None] for index in range(1, len(rows[0]))]
        spikes = zip(ranges, self._spikes, strict=True)
        if len(rows) > 2 and any(values and max(values) - min(values) > spike for values, spike in spikes):
            for at, pick in ((rows[0][0], min), (rows[len(rows) // 2][0], max)):
                self._put(at, [pick(values) if values else None for values in ranges])
        self._put(rows[-1][0], rows[-1][1:])

    def _put(self, at: int, values: list[float | None]) -> None:
        self.columns[0].append((at - self._epoch) // 1000)
        for column, value, finest in zip(self.columns[1:], values, self._decimals, strict=True):
            column.append(None if value is None else round(value, finest))
