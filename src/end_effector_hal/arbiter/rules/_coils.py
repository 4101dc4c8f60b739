"""Translates the level of an output into the lines that drive it: one line, or the two coils of a valve."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines import LineBackend

_log = logging.getLogger("end_effector_hal.arbiter")


class SecondCoil(NamedTuple):
    """The second coil of an output, which drives the device back.

    Attributes:
        line: the line of that coil.
        pulse_us: length of the pulse at each change; the device keeps its position without power. 0: one of the two
            coils is always active.
        pause_us: time from the end of a pulse to the next pulse; 0: a change cuts a pulse short.
    """

    line: str
    pulse_us: int = 0
    pause_us: int = 0


class Coils:
    """Writes outputs and records what was written; a coil is never active together with its opposite.

    The position of a device is unknown if no coil is active and no record of an earlier arbiter has the last pulse, or
    if the back-end does not report a line. Its output is then a guess and counts as active, until a client writes it
    or the back-end reports it, because a part may be held.

    Args:
        backend: the lines; they are not claimed yet.
        opposites: the second coils, by the line of the output.
        before_change: called before a line is written.
    """

    def __init__(
        self, backend: LineBackend, opposites: Mapping[str, SecondCoil], before_change: Callable[[], None]
    ) -> None:
        self._backend, self._opposites, self._before_change = backend, opposites, before_change
        self._pulsed: dict[str, bool] = {}
        self._ends: dict[str, int] = {}
        """End of the current pulse by line, µs."""
        self._paused: dict[str, int] = {}
        """End of the pause by output, µs."""
        self.guessed = frozenset[str]()
        """Outputs of unknown position; they count as active."""
        self._undriven = frozenset[str]()
        """Outputs with two held coils that were adopted as active although neither of their coils is active."""

    def request(self, lines: Sequence[str], believed: Mapping[str, bool], at: int) -> dict[str, bool]:
        """Claim all lines, adopt their state, and return the levels of the outputs. No coil is activated at the start.

        A pulse that is active at the start lasts its whole length from now, because its start is unknown.

        Args:
            lines: the lines of the outputs.
            believed: recorded positions of the outputs that are driven by pulses.
            at: the time now, µs.
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
        """Return the levels of the outputs, read back where the hardware reports them; unknown ones are left out."""
        found = self._backend.levels()
        self.guessed -= found.keys() - self._opposites.keys()  # it has become known
        unread = {each.line for each in self._opposites.values()} | self.guessed
        return {
            line: self._pulsed.get(line, level or line in self._undriven)
            for line, level in found.items()
            if line not in unread
        }

    def decide(self, lines: Iterable[str]) -> None:
        """End the guess for these outputs, because a client that reads the sensors has written them."""
        decided = self.guessed.intersection(lines)
        self.guessed -= decided
        self._undriven |= decided & self._opposites.keys() - self._pulsed.keys()

    def set(self, changes: Mapping[str, bool], at: int) -> None:
        """Write outputs: deactivations first, then activations. Raises the errors of the lines."""
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
        """Return the known end of the pause after an output's last pulse, µs; 0: there is no pause."""
        opposite = self._opposites.get(line)
        if opposite is None or not opposite.pause_us:
            return 0
        ends = [self._ends[each] for each in (line, opposite.line) if each in self._ends]
        return max([self._paused.get(line, 0), *(end + opposite.pause_us for end in ends)])

    @property
    def due(self) -> int | None:
        """The time at which the next pulse ends, µs; None: there is none."""
        return min(self._ends.values(), default=None)

    @property
    def pulsed(self) -> dict[str, bool]:
        """Levels of the outputs whose level cannot be read from their lines (driven by pulses), without guesses."""
        return {line: level for line, level in self._pulsed.items() if line not in self.guessed}

    def advance(self, at: int) -> None:
        """End the pulses that are over; if ending one fails, it is tried again one pulse length later."""
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
        """End all pulses now; an output whose pulse is cut short becomes a guess. Raises the errors of the lines."""
        under_way = self._ends.keys()
        short = {line for line, each in self._opposites.items() if {line, each.line} & under_way}
        self.guessed |= short
        self.advance(max(self._ends.values(), default=0))
