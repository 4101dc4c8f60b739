"""Grippers without air: fingers with a spring that opens them, and a magnet."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from ._device import ACTUATOR, PARTS, STICKS, Device
from ._parts import STEP_S, Valve

TRAVEL_S = 0.3
"""Time from open to fully closed, s; 0.03 to 0.5 s are usual."""
PART_AT = 0.6
"""Share of the travel at which a part stops the fingers."""
_SWITCH = 0.02  # an end switch is made over the last 2 % of the way
_TRAVEL = STEP_S / TRAVEL_S


class Leg(NamedTuple):
    """A part of a motion: to a position, 0 open to 1 closed, at a speed in strokes per second."""

    to: float
    speed: float


class Fingers(Device):
    """Fingers that close on the part between them, or fully if there is none.

    A controller of their own may `drive` them: then they follow its motor, and only while its command to close or to
    open has an effect; the faults of a scenario decide that.

    Args:
        valve: closes them when open.
    """

    traits: ClassVar = frozenset({ACTUATOR, PARTS})
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "open"
    empty_bit: ClassVar = "closed"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(30_000), start)
        self.position = 0.0  # 0 open, 1 closed on nothing
        self._part = True
        self._lost = False
        self._legs: tuple[Leg, ...] | None = None  # None: no motor
        self._closes = False

    @property
    def bits(self) -> Mapping[str, bool]:
        return {
            "open": self.position <= _SWITCH,
            "closed": self.position >= 1 - _SWITCH,
            "part": self._on_part and self.position == PART_AT,
        }

    @property
    def settled(self) -> bool:
        return self.valve.settled and self.has_stopped

    @property
    def has_stopped(self) -> bool:
        """Whether they are where they go, or cannot move."""
        return self.position == self._end and (self._is_blocked or not (self._legs or ())[1:])

    @property
    def moves(self) -> bool:
        """Whether their motor runs, or is about to."""
        return not self.settled

    @property
    def closes(self) -> bool:
        """Whether they are commanded to close, by their motor or by their valve."""
        return self.valve.is_open if self._legs is None else self._closes

    def drive(self, *legs: Leg, closes: bool) -> None:
        """Let a motor move them from now on, one leg after the other; without a leg it holds them where they are.

        Args:
            legs: the motion; the last one lasts, so that they go on when a part is lost.
            closes: whether they are commanded to close, which a scenario may prevent.
        """
        self._legs, self._closes = legs, closes

    def stop(self) -> None:
        """Let the motor hold them where they are."""
        self.drive(closes=self.closes)

    def command(self, active: bool, at: int) -> None:
        self._lost = self._lost and active
        super().command(active, at)

    def lose(self, at: int) -> None:
        """Remove the part, pulled out or broken: the fingers close fully."""
        self._lost = True

    def meet(self, part: bool) -> None:
        self._part = part

    def settle(self, active: bool) -> None:
        self.valve.settle(active)
        self.position = self._end
        while self._legs and self._legs[1:]:
            self._legs = self._legs[1:]
            self.position = self._end

    def step(self) -> None:
        self.valve.advance(self.now)
        travel = self._legs[0].speed * STEP_S if self._legs else _TRAVEL
        if self.position < self._end:
            self.position = min(self.position + travel, self._end)
        else:
            self.position = max(self.position - travel, self._end)
        if self._legs and self._legs[1:] and self.position == self._end and not self._is_blocked:
            self._legs = self._legs[1:]

    @property
    def _on_part(self) -> bool:
        return self._part and not self._lost

    @property
    def _is_blocked(self) -> bool:
        """Whether a motor has no effect: a scenario does not let it follow its command."""
        return self._legs is not None and self.valve.is_open != self._closes

    @property
    def _end(self) -> float:
        if self._legs is None:
            to = 1.0 if self.valve.is_open else 0.0
        elif self._legs and not self._is_blocked:
            to = self._legs[0].to
        else:
            return self.position
        stops = self._on_part and to > PART_AT and (self._legs is None or self.position <= PART_AT)
        return PART_AT if stops else to


FIELD_S = 0.06
"""Time constant of its field, s; includes the residual field of the part."""
_SHARE = 1.0 - math.exp(-STEP_S / FIELD_S)
_HOLDS, _DROPS = 0.6, 0.1  # of its field: from here on it holds a part; less than this lets it fall
_STILL = 1e-6


class HoldingMagnet(Device):
    """A magnet that holds a part from 60 % of its field on, and drops it below 10 %.

    A part that sticks because of residual magnetism drops when it is blown off.

    Args:
        valve: switches its current, or the air that moves its magnets.
    """

    traits: ClassVar = frozenset({ACTUATOR, PARTS, STICKS})
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "gone"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(20_000), start)
        self.field = 0.0
        self._part, self._lost, self._holds, self._sticks = True, False, False, False
        self._blow_off = Valve(self.valve.delay_us)

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"part": self._holds, "gone": not self._holds}

    @property
    def settled(self) -> bool:
        falls = self._holds and self.field < _DROPS and not self._sticks
        return (
            not falls
            and self.valve.settled
            and self._blow_off.settled
            and abs(self._target - self.field) < _STILL
        )

    def command(self, active: bool, at: int) -> None:
        self._lost = self._lost and active
        super().command(active, at)

    def lose(self, at: int) -> None:
        """Tear off the part."""
        self._lost, self._holds = True, False

    def meet(self, part: bool) -> None:
        self._part = part
        self._holds = part and (self._holds or self.field >= _HOLDS)

    def stick(self, sticks: bool) -> None:
        self._sticks = sticks

    def blow(self, active: bool, at: int) -> None:
        self._blow_off.command(active, at)

    def settle(self, active: bool) -> None:
        self.valve.settle(active)
        self.field = self._target
        self._holds = self._part and active

    def step(self) -> None:
        self.valve.advance(self.now)
        self._blow_off.advance(self.now)
        self.field += (self._target - self.field) * _SHARE
        if self.field >= _HOLDS and self._part and not self._lost:
            self._holds = True
        elif self.field < _DROPS and (self._blow_off.is_open or not self._sticks):
            self._holds = False

    @property
    def _target(self) -> float:
        return 1.0 if self.valve.is_open else 0.0
