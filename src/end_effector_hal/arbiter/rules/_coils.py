"""From the level of an output to the wires that drive it: one line, or two coils of a valve."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.wires.lines import LineBackend

_log = logging.getLogger("end_effector_hal.arbiter")


class SecondCoil(NamedTuple):
    """The second coil of an output: it drives the device back.

    Attributes:
        line: of that coil.
        pulse_us: 0: one of the two coils is active all the time; else each change is a pulse of this length, and the
            device keeps its position without power.
    """

    line: str
    pulse_us: int = 0


class Coils:
    """Writes outputs, and knows what was written; no coil is ever active together with its opposite.

    A pulse leaves no level behind that could be read back: where no record of an earlier arbiter says what was pulsed
    last, the output counts as active. A part that may be held is held until a Drop.

    Args:
        backend: the lines, not claimed yet.
        opposites: by the line of the output.
        before_change: called before a line is written.
    """

    def __init__(
        self, backend: LineBackend, opposites: Mapping[str, SecondCoil], before_change: Callable[[], None]
    ) -> None:
        self._backend, self._opposites, self._before_change = backend, opposites, before_change
        self._pulsed: dict[str, bool] = {}
        self._ends: dict[str, int] = {}
        """When the pulse of a line is over, µs."""
        self.guessed = frozenset[str]()
        """Outputs of which nothing was known at the start: they count as active."""

    def request(self, lines: Sequence[str], believed: Mapping[str, bool]) -> dict[str, bool]:
        """Claim all lines and adopt them; returns the levels of the outputs.

        An output of two coils that are both inactive is inactive, and neither coil is driven: a start moves nothing.
        """
        found = self._backend.request([*lines, *(each.line for each in self._opposites.values())])
        levels, off, guessed = {line: found[line] for line in lines}, set[str](), set[str]()
        for line, opposite in self._opposites.items():
            if found[line] and found[opposite.line]:
                _log.error("both coils of one output were active: %s and %s", line, opposite.line)
                off.add(opposite.line)
            if opposite.pulse_us:
                if not found[line] and not found[opposite.line] and line not in believed:
                    _log.warning("no record says how %s was pulsed last: it counts as active", line)
                    guessed.add(line)
                known = found[line] or (not found[opposite.line] and believed.get(line, True))
                self._pulsed[line] = levels[line] = known
                off |= {each for each in (line, opposite.line) if found[each]}
        if off:
            self._before_change()
            self._backend.set(dict.fromkeys(off, False))
        self.guessed = frozenset(guessed)
        return levels

    def read(self) -> dict[str, bool]:
        """The levels of the outputs, read back where a level stands."""
        found = self._backend.levels()
        second = {each.line for each in self._opposites.values()}
        return {line: self._pulsed.get(line, level) for line, level in found.items() if line not in second}

    def set(self, changes: Mapping[str, bool], at: int) -> None:
        """Write outputs: first what becomes inactive, then what becomes active; raises what the lines raise."""
        off, on, ends = set[str](), set[str](), dict[str, int]()
        for line, level in changes.items():
            opposite = self._opposites.get(line)
            (on if level else off).add(line)
            if opposite is None:
                continue
            (off if level else on).add(opposite.line)
            if opposite.pulse_us:
                ends[line if level else opposite.line] = at + opposite.pulse_us
        if off:
            self._backend.set(dict.fromkeys(off, False))
        if on:
            self._backend.set(dict.fromkeys(on, True))
        for line in off:
            self._ends.pop(line, None)
        self._ends |= ends
        self._pulsed |= {line: level for line, level in changes.items() if line in self._pulsed}

    @property
    def due(self) -> int | None:
        """When the next pulse is over, µs; None: there is none."""
        return min(self._ends.values(), default=None)

    @property
    def pulsed(self) -> dict[str, bool]:
        """The levels of the outputs that leave none on their lines."""
        return dict(self._pulsed)

    def advance(self, at: int) -> None:
        """End the pulses that are over; one that cannot be ended is tried again one pulse later."""
        over = [line for line, end in self._ends.items() if end <= at]
        if not over:
            return
        lengths = {line: each.pulse_us for line, each in self._opposites.items()}
        lengths |= {each.line: each.pulse_us for each in self._opposites.values()}
        for line in over:
            self._ends[line] = at + lengths[line]
        self._backend.set(dict.fromkeys(over, False))
        for line in over:
            del self._ends[line]
