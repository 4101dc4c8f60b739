"""From the level of an output to the wires that drive it: one line, or two coils of a valve."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines import LineBackend

_log = logging.getLogger("end_effector_hal.arbiter")


class SecondCoil(NamedTuple):
    """The second coil of an output: it drives the device back.

    Attributes:
        line: of that coil.
        pulse_us: 0: one of the two coils is active all the time; else each change is a pulse of this length, and the
            device keeps its position without power.
        pause_us: from the end of a pulse to the next one; 0: a change cuts a pulse short.
    """

    line: str
    pulse_us: int = 0
    pause_us: int = 0


class Coils:
    """Writes outputs, and knows what was written; no coil is ever active together with its opposite.

    Where no coil is active and no record of an earlier arbiter says what was pulsed last, nobody knows how the device
    stands; nor does anybody where its back-end leaves a line out. Such an output is a guess and counts as active, until
    somebody writes it, or its back-end knows. A part that may be held is held.

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
        self._paused: dict[str, int] = {}
        """When the pause of an output is over, µs."""
        self.guessed = frozenset[str]()
        """Outputs of which nothing is known, and that count as active."""
        self._undriven = frozenset[str]()
        """Held outputs that were taken as active as they stand: no coil of theirs is active."""

    def request(self, lines: Sequence[str], believed: Mapping[str, bool], at: int) -> dict[str, bool]:
        """Claim all lines and adopt them; returns the levels of the outputs. A start drives no coil.

        A pulse that is found under way lasts its whole length from now: nobody knows how long it has lasted.

        Args:
            lines: of the outputs.
            believed: how pulsed outputs stand, where a record says it.
            at: now, µs.
        """
        found = self._backend.request([*lines, *(each.line for each in self._opposites.values())])
        levels, off = {line: found.get(line, True) for line in lines}, set[str]()
        guessed = {line for line in lines if line not in found}
        for line, opposite in self._opposites.items():
            if found[line] and found[opposite.line]:
                _log.error("both coils of one output were active: %s and %s", line, opposite.line)
                off.add(opposite.line)
            known = found[line] or found[opposite.line] or (opposite.pulse_us and line in believed)
            if not known:
                guessed.add(line)
                levels[line] = True
            elif opposite.pulse_us and not found[line]:
                levels[line] = not found[opposite.line] and believed[line]
            if opposite.pulse_us:
                self._pulsed[line] = levels[line]
                self._paused[line] = at + opposite.pause_us  # nobody knows when the last pulse was
                under_way = {each for each in (line, opposite.line) if found[each]} - off
                self._ends |= dict.fromkeys(under_way, at + opposite.pulse_us)
        if off:
            self._before_change()
            self._backend.set(dict.fromkeys(sorted(off), False))
        for line in sorted(guessed):
            _log.warning("the position of %s is unknown: it counts as active", line)
        self.guessed = frozenset(guessed)
        return levels

    def read(self) -> dict[str, bool]:
        """The levels of the outputs, read back where a level stands; without those of which nothing is known."""
        found = self._backend.levels()
        self.guessed -= found.keys() - self._opposites.keys()  # it has become known
        unread = {each.line for each in self._opposites.values()} | self.guessed
        return {
            line: self._pulsed.get(line, level or line in self._undriven)
            for line, level in found.items()
            if line not in unread
        }

    def decide(self, lines: Iterable[str]) -> None:
        """Somebody who knows the sensors has written these outputs: they are no guess any more."""
        decided = self.guessed.intersection(lines)
        self.guessed -= decided
        self._undriven |= decided & self._opposites.keys() - self._pulsed.keys()

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
            self._backend.set(dict.fromkeys(sorted(off), False))
        for line in off:
            self._ends.pop(line, None)
        # before the write: of several chips, one may have been written when another one fails
        self._ends |= ends
        self._pulsed |= {line: True for line, level in changes.items() if level and line in self._pulsed}
        if on:
            self._backend.set(dict.fromkeys(sorted(on), True))
        self._pulsed |= {line: level for line, level in changes.items() if line in self._pulsed}
        self._undriven -= changes.keys()

    def ready_at(self, line: str) -> int:
        """When the pause after the last pulse of an output is over, as far as is known, µs; 0: there is none."""
        opposite = self._opposites.get(line)
        if opposite is None or not opposite.pause_us:
            return 0
        ends = [self._ends[each] for each in (line, opposite.line) if each in self._ends]
        return max([self._paused.get(line, 0), *(end + opposite.pause_us for end in ends)])

    @property
    def due(self) -> int | None:
        """When the next pulse is over, µs; None: there is none."""
        return min(self._ends.values(), default=None)

    @property
    def pulsed(self) -> dict[str, bool]:
        """The levels of the outputs that leave none on their lines; a guess is not among them."""
        return {line: level for line, level in self._pulsed.items() if line not in self.guessed}

    def advance(self, at: int) -> None:
        """End the pulses that are over; one that cannot be ended is tried again one pulse later."""
        over = [line for line, end in self._ends.items() if end <= at]
        if not over:
            return
        outputs = {coil: line for line, each in self._opposites.items() for coil in (line, each.line)}
        failed: Exception | None = None
        for line in over:
            output = outputs[line]
            opposite = self._opposites[output]
            try:
                self._backend.set({line: False})
            except (WireError, OSError) as error:
                self._ends[line], failed = at + opposite.pulse_us, error
            else:
                del self._ends[line]
                self._paused[output] = at + opposite.pause_us
        if failed is not None:
            raise failed

    def cut(self) -> None:
        """End all pulses now; of what is cut short nobody knows how it stands. Raises what the lines raise."""
        under_way = self._ends.keys()
        short = {line for line, each in self._opposites.items() if {line, each.line} & under_way}
        self.guessed |= short
        self.advance(max(self._ends.values(), default=0))
