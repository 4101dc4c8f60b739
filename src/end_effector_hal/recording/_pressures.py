"""``pressures.csv``: gauge pressures in kPa, and other quantities in their units, thinned for figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path

from end_effector_hal.description import QUANTITIES
from end_effector_hal.errors import UsageError

from ._files import RecordingLimits
from ._rows import Line, TableWriter, read_header, read_lines, read_rows

FIXED = ("time_s",)
UNIT = "_gauge_kpa"
"""Ending of a pressure's column name, after the name of the channel."""
KPA = "kPa"
OF_QUANTITIES = {unit: f"_{unit.lower().replace('%', 'percent')}" for unit in QUANTITIES}
"""Endings of the column names of other quantities, by their unit."""
_UNITS = {UNIT: KPA} | {ending: unit for unit, ending in OF_QUANTITIES.items()}
PERIOD_S, JITTER_S = 0.02, 0.005
LONGEST_GAP_S = 0.5
STEP_KPA, STEP = 0.2, 0.005
"""Smallest change that counts as a move: of a pressure, kPa, and of another quantity, in its unit."""

Sample = tuple[float, tuple[float | None, ...]]


@dataclass(frozen=True)
class PressuresLog:
    """Samples in order of time: seconds since start, gauge kPa per channel, None = invalid or stale.

    A channel in ``units`` is a quantity in that unit, not a pressure.
    """

    channels: tuple[str, ...]
    samples: tuple[Sample, ...]
    source: str = ""
    note: str = ""
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def times_s(self) -> tuple[float, ...]:
        """The time of each sample, seconds since the start."""
        return tuple(time_s for time_s, _ in self.samples)

    def curve(self, channel: str) -> tuple[float | None, ...]:
        """Return the values of one channel, kPa."""
        index = self.channels.index(channel)
        return tuple(values[index] for _, values in self.samples)


class PressuresWriter(TableWriter[Sample]):
    """Writes at most 50 samples a second, and two a second of a steady pressure.

    A sample is left out while every channel stays within 0.2 kPa (or 0.005 of another unit) of the last written one,
    for at most 0.5 s. When a pressure moves again, the last sample that was left out is written too, so that the edge
    keeps its steepness. A channel that becomes invalid or valid is written at once. After samples that could not be
    written, a row without values is written first, with the time of the first of them. Thread-safe.
    """

    def __init__(
        self,
        path: str | Path,
        channels: Sequence[str],
        limits: RecordingLimits | None = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        self._channels = tuple(channels)
        units = {name: unit for name, unit in (units or {}).items() if unit != KPA}
        self._steps = tuple(STEP if channel in units else STEP_KPA for channel in self._channels)
        self._decimals = tuple(3 if channel in units else 2 for channel in self._channels)
        self._gap: Sample | None = None
        self._left_out: Sample | None = None
        self._due_s = 0.0
        columns = (column_of(channel, units) for channel in self._channels)
        super().__init__(path, (*FIXED, *columns), limits)
        self._last = self._resumed(lambda line: _sample(line, self._channels, 0.0))

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels, in the order of the columns."""
        return self._channels

    def write(self, time_s: float, kpa: Mapping[str, float | None]) -> bool:
        """Offer a sample and return whether it was written.

        The time is in seconds since the start, the values are in gauge kPa; a missing value or None is invalid.
        """
        self._check_time(time_s)
        values = tuple(_finite(kpa.get(channel)) for channel in self._channels)
        with self._lock:
            known = (each[0] for each in (self._last, self._left_out, self._gap) if each)
            sample: Sample = (max(time_s, *known, 0.0), values)
            changed = self._last is None or not self._same_validity(values)
            if sample[0] < self._due_s - JITTER_S and not changed:
                return False
            # counted from when it was due, so that a late sample does not cost the next one its place
            self._due_s = max(self._due_s + PERIOD_S, sample[0])
            if self._last is None or changed:
                self._append(sample, with_left_out=True)
                return True
            steady = self._steady(values)
            if steady and sample[0] - self._last[0] < LONGEST_GAP_S:
                self._left_out = sample
                return False
            self._append(sample, with_left_out=not steady)
        return True

    def _same_validity(self, values: Sequence[float | None]) -> bool:
        assert self._last is not None
        return all((old is None) == (new is None) for old, new in zip(self._last[1], values, strict=True))

    def _steady(self, values: Sequence[float | None]) -> bool:
        assert self._last is not None
        pairs = zip(self._last[1], values, self._steps, strict=True)
        return all(old is None or new is None or abs(new - old) < step for old, new, step in pairs)

    def _append(self, sample: Sample, *, with_left_out: bool) -> None:
        before = (self._gap, self._left_out if with_left_out else None)
        rows = sorted((row for row in before if row is not None), key=itemgetter(0))
        self._gap = self._gap or (sample[0], (None,) * len(self._channels))
        self._file.append("".join(map(self._text, [*rows, sample])))
        self._last, self._left_out, self._gap = sample, None, None

    def _text(self, sample: Sample) -> str:
        time_s, values = sample
        pairs = zip(values, self._decimals, strict=True)
        numbers = ("" if value is None else f"{value:.{decimals}f}" for value, decimals in pairs)
        return ",".join([f"{time_s:.6f}", *numbers]) + "\n"

    def close(self) -> None:
        """Write the last sample that was left out, and close the file; may be called again."""
        with self._lock:
            try:
                if self._left_out is not None:
                    self._append(self._left_out, with_left_out=False)
            finally:
                super().close()


def read_pressures(path: str | Path) -> PressuresLog:
    """Read a recording of pressures; raises UsageError with ``file:line`` if it is another kind of file.

    A last line without its end is dropped and reported in ``note``, because its last number may have lost digits.
    """
    lines = read_lines(path)
    units = _units_of(read_header(lines, path, FIXED), f"{path}:1")
    channels = tuple(units)
    samples, note = read_rows(
        lines, lambda line, earliest_s: _sample(line, channels, earliest_s), itemgetter(0)
    )
    quantities = {channel: unit for channel, unit in units.items() if unit != KPA}
    return PressuresLog(channels, tuple(samples), str(path), note, quantities)


def last_pressures(path: str | Path, spans: Sequence[tuple[float, float]]) -> list[dict[str, float]]:
    """Return, for each span of time, the last valid gauge pressure of each channel in it, kPa.

    The table is read row by row, because it may be too large for the memory.

    Args:
        path: path of the table.
        spans: begin and end, seconds since the start; in order, and not overlapping. The end is not part of a span.

    Raises:
        UsageError: as `read_pressures` does.
    """
    lines = read_lines(path)
    units = _units_of(read_header(lines, path, FIXED), f"{path}:1")
    found: list[dict[str, float]] = [{} for _ in spans]
    index, earliest_s = 0, 0.0
    for line in lines:
        if not line.complete:
            break
        earliest_s, values = _sample(line, tuple(units), earliest_s)
        while index < len(spans) and earliest_s >= spans[index][1]:
            index += 1
        if index == len(spans):
            break
        if earliest_s >= spans[index][0]:
            pairs = zip(units.items(), values, strict=True)
            found[index] |= {name: kpa for (name, unit), kpa in pairs if unit == KPA and kpa is not None}
    return found


def column_of(channel: str, units: Mapping[str, str]) -> str:
    """Return the name of a column, with its unit; a channel that is not in ``units`` is a gauge pressure."""
    return f"{channel}{OF_QUANTITIES.get(units.get(channel, KPA), UNIT)}"


def _units_of(columns: tuple[str, ...], where: str) -> dict[str, str]:
    """Return the unit of each channel of a header."""
    found: dict[str, str] = {}
    for column in columns:
        ending = next((each for each in _UNITS if column.endswith(each) and column != each), None)
        if ending is None:
            raise UsageError(
                f"The column {column!r} has no unit, expected is a name that ends in {', '.join(_UNITS)}.",
                where=where,
            )
        channel = column.removesuffix(ending)
        if channel in found:
            raise UsageError(f"The channel {channel!r} has two columns.", where=where)
        found[channel] = _UNITS[ending]
    return found


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) and abs(value) < 1e9 else None


def _sample(line: Line, channels: tuple[str, ...], earliest_s: float) -> Sample:
    time, *values = line.fields((*FIXED, *channels))
    pairs = zip(values, channels, strict=True)
    return line.seconds(time, earliest_s), tuple(
        line.number_of(text, name) if text else None for text, name in pairs
    )
