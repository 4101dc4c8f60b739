"""Bounded data of a recording: samples that preserve spikes, and views at many moments stored as changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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


_ABSENT = object()


class Tracks:
    """Stores, for each track, the numbers of the moments at which its value changed, and the new values."""

    def __init__(self) -> None:
        self.times: list[int] = []
        self._last: dict[str, Any] = {}
        self._tracks: dict[str, tuple[list[int], list[Any]]] = {}
        self.changes = 0

    def note(self, at: int, view: dict[str, Any]) -> None:
        """Add the view that is valid from ``at`` µs on."""
        number, leaves = len(self.times), dict(_leaves(view))
        self.times.append(at)
        for path in self._last.keys() - leaves.keys():
            leaves[path] = None
        for path, value in leaves.items():
            if self._last.get(path, _ABSENT) != value:
                self._last[path] = value
                numbers, values = self._tracks.setdefault(path, ([], []))
                numbers.append(number)
                values.append(value)
                self.changes += 1

    def as_json(self) -> dict[str, Any]:
        """Return ``[numbers, values]`` by path; a number is the difference from the one before it."""
        return {path: [_differences(numbers), values] for path, (numbers, values) in self._tracks.items()}


def _leaves(view: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield paths and values: ``state.word``, ``cards.0.values``, ``interlocks.3``, ``automata.Gripper``."""
    state, cards = view["state"], view["cards"]
    yield "state", state is not None
    for name, value in (state or {}).items():
        yield f"state.{name}", value
    for number, card in enumerate(cards or ()):
        for name, value in card.items():
            yield f"cards.{number}.{name}", value
    for number, row in enumerate(view["interlocks"]):
        yield f"interlocks.{number}", row
    for name, where in view["automata"].items():
        yield f"automata.{name}", where


def _differences(numbers: list[int]) -> list[int]:
    return [after - before for before, after in zip([0, *numbers], numbers, strict=False)]
