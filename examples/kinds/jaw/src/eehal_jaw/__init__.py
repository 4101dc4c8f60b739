"""A jaw with an open and a closed switch: its keys, its states, its evidence."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from end_effector_hal.kinds import ChannelKey, ChannelReadings, DeviceKind
from end_effector_hal.kinds.stanza import Actuator, Name, Seconds, Supply
from end_effector_hal.signals import NESTED, Kind, Streak
from end_effector_hal.vocabulary import Evidence, TableState, to_us


class JawActuator(Actuator):
    """A jaw that an active line closes, and a spring opens."""

    kind: Literal["jaw"] = Field(description="what it is")
    channel: Literal["none"] = Field(default="none", description="a jaw has no pressure sensor")
    closed_bit: Name = Field(default="jaw_closed", description="bit that proves closed")
    open_bit: Name = Field(default="jaw_open", description="bit that proves open; none: no such switch")
    stands_s: Seconds = Field(default=0.05, description="closed for at least this long")


class JawState(TableState):
    """The words of a jaw for the integers of Table II."""

    OPEN = 0
    PENDING_CLOSE = 1
    CLOSED = 2


class JawDetector:
    """Closed (confirmed) when its switch has stood for ``stands_s``, open (gone) by the other one."""

    MEMORY: ClassVar = {"_closed": NESTED}

    def __init__(self, actuator: JawActuator) -> None:
        self._actuator = actuator
        self._closed = Streak()

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """The evidence at ``at`` µs; where no open switch is fitted, open is the opposite of closed."""
        closed = readings.fresh.get(self._actuator.closed_bit)
        opened = readings.fresh.get(self._actuator.open_bit)
        if self._actuator.open_bit not in readings.carried and closed is not None:
            opened = not closed
        if closed is None or opened is None:
            self._closed = Streak()
            return Evidence.UNKNOWN
        self._closed.take(bool(closed) and not opened, at)
        if self._closed.lasted(at, to_us(self._actuator.stands_s)):
            return Evidence.CONFIRMED
        return Evidence.GONE if opened and not closed else Evidence.PARTIAL


class Jaw(DeviceKind[JawActuator]):
    """Confirmed when it is closed."""

    name = "jaw"
    stanza = JawActuator
    channels = (ChannelKey("closed_bit", Kind.BIT, confirms=True), ChannelKey("open_bit", Kind.BIT))
    states = JawState
    orders = (("stands_s", "<", "timeout_s"),)

    def detector(self, actuator: JawActuator, supply: Supply) -> JawDetector:
        """From its two switches."""
        return JawDetector(actuator)

    def lost(self, actuator: JawActuator, readings: ChannelReadings, at: int) -> str:
        """What its closed switch shows."""
        return (
            f"{actuator.closed_bit} is off"
            if readings.get(actuator.closed_bit, at) is False
            else "its switches do not agree"
        )

    def not_fitted(self, actuator: JawActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """What is not seen without the open switch."""
        if actuator.open_bit not in carried:
            yield f"open_bit: {actuator.open_bit}: a jaw that stops on its way is taken for open"
