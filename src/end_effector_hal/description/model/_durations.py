"""Longest times of a grip, a release and a cancel: as the integrator requires, or as the sum of the steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.vocabulary import SETTLE_US

from ._stanzas import Bounds

BUS_MS = 100
"""Time in which a device acknowledges a write, ms; the gap before a blow-off begins there."""


@dataclass(frozen=True, slots=True)
class Durations:
    """Time limits that the proof verifies for the automata, ms.

    Attributes:
        grip_ms, release_ms, cancel_ms: longest time of a grip, of a release, and of unwinding a cancelled grip.
        computed: keys of `bounds` that are not written and were computed.
    """

    grip_ms: int
    release_ms: int
    cancel_ms: int
    computed: tuple[str, ...] = ()

    def seconds(self, key: str) -> float:
        """Return a limit in seconds by its key in ``bounds``, such as ``grip_s``."""
        found: int = getattr(self, f"{key.removesuffix('_s')}_ms")
        return found / 1000


@dataclass(frozen=True, slots=True)
class BlowOffTimes:
    """Times of the blow-off during a release, ms.

    Attributes:
        line: line of the blow-off valve.
        gap_ms: gap that the line arbiter enforces.
        rest_ms: time before and after blowing, with neither suction nor blowing.
        blow_ms: longest time of blowing.
        until_gone: whether blowing ends as soon as the feedback is gone.
        late_ms: largest delay of each of the three deadlines.
    """

    line: str
    gap_ms: int
    rest_ms: int
    blow_ms: int
    until_gone: bool
    late_ms: int

    @property
    def whole_ms(self) -> int:
        """Longest time that the blow-off adds to a release, ms."""
        return 2 * self.rest_ms + self.blow_ms + 3 * self.late_ms

    @property
    def most_ms(self) -> int:
        """Time after which the line arbiter ends the blow-off, whatever the program does, ms."""
        return self.blow_ms + 2 * self.late_ms


def blow_off_of(actuator: Actuator, bounds: Bounds) -> BlowOffTimes | None:
    """Return the times of an actuator's blow-off during a release; None: a release does not blow.

    The line arbiter refuses a write within the gap and does not wait, so the automata leave more time: a write may
    wait for its line to settle (IL-10), and be late.
    """
    output = kind_of(actuator).opposing_output(actuator)
    duration_s: float | None = getattr(output, "duration_s", None)
    if duration_s is None:
        return None
    gap_ms, late_ms = _ms(output.gap_s), bounds.reaction_ms
    settle_ms, coil = SETTLE_US // 1000, actuator.modbus or actuator.opposite
    if coil is not None and coil.pulse_s is not None and (actuator.modbus or coil.pause_s):
        settle_ms = _ms(coil.pulse_s + (coil.pause_s or 0)) + late_ms
    if actuator.modbus or output.modbus:
        settle_ms += BUS_MS
    rest_ms = gap_ms + settle_ms + late_ms
    return BlowOffTimes(output.line, gap_ms, rest_ms, _ms(duration_s), output.until_gone, late_ms)


def durations(steps: Sequence[Actuator], grips: Sequence[Sequence[Actuator]], bounds: Bounds) -> Durations:
    """Return the time limits of a tool (`docs/explanation/verification.md`, worst cases).

    Args:
        steps: its actuators, all of which a release may have to wait for.
        grips: the actuators that grip, for each of its parts.
        bounds: the limits that the description writes.

    A grip is longest if every attempt of each step times out and is followed by its pause, except for the last
    attempt, and the last step fails as well. A release is longest if each blow-off runs for its full time and no
    feedback disappears in time after it. Each deadline is late by D. An ending that holds, or continues without a
    pause, only shortens it.
    """
    late = bounds.reaction_ms
    blown = (blow_off_of(step, bounds) for step in steps)
    released = sum(_ms(step.release_s) + late for step in steps) + sum(
        each.whole_ms for each in blown if each
    )
    decided = max(
        sum(
            step.attempts * (_ms(step.timeout_s) + late) + (step.attempts - 1) * (_ms(step.reset_s) + late)
            for step in gripping
        )
        for gripping in grips
    )
    longest = {"grip_s": decided + released, "release_s": released, "cancel_s": released}
    written = {key: getattr(bounds, key) for key in longest if getattr(bounds, key) is not None}
    grip, release, cancel = (
        _ms(written[key]) if key in written else longest_ms for key, longest_ms in longest.items()
    )
    return Durations(grip, release, cancel, tuple(key for key in longest if key not in written))


def _ms(seconds: float) -> int:
    return round(seconds * 1000)
