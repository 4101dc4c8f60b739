"""One unit of a bus by its maker's manual: which requests it executes, and how it refuses others."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

from end_effector_lab.testbench.physics import Device, Fingers

from ._frames import (
    ILLEGAL_ADDRESS,
    ILLEGAL_FUNCTION,
    ILLEGAL_VALUE,
    READS,
    done_answer,
    parsed,
    read_answer,
    refusal,
)

_MOST = {1: 2000, 2: 2000, 3: 125, 4: 125, 15: 1968, 16: 123, 23: 121}
"""Most registers or bits of one request, by its function."""

Tell = Callable[[int, bool], None]
"""Called with the channel of an actuator and whether it is driven to hold."""


class NoSuchRegisterError(LookupError):
    """The unit has no such register, or does not allow this access: exception 2."""


class BadValueError(ValueError):
    """The unit does not accept this value: exception 3."""


def fingers_of(devices: Mapping[int, Device]) -> Fingers:
    """Return the fingers of a gripper that has one actuator."""
    fingers = devices[0]
    assert isinstance(fingers, Fingers)
    return fingers


class UnitModel(ABC):
    """A device as its maker's manual describes it.

    Its registers come from the manual, never from the description of a tool. The physics of the testbench decides what
    happens between its fingers or under its cups. Time is an argument, µs.

    Args:
        devices: the physics of its actuators, by channel.
        tell: called when it begins to drive an actuator to hold, or to release.

    Attributes:
        name: name in a library of devices.
        functions: the function codes that it executes.
        alarm: fault code that a scenario makes it show; 0: none.
    """

    name: ClassVar[str]
    functions: ClassVar[frozenset[int]]
    physics: ClassVar[type]
    """The physics that it can drive."""

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        self.devices, self._tell = devices, tell
        self.alarm = 0

    @staticmethod
    def channel_of(_address: int) -> int:
        """Return the channel of the actuator that the register or coil at this address commands."""
        return 0

    @abstractmethod
    def power_up(self, at: int) -> None:
        """Switch on: registers have their first values, nothing is driven, and what was commanded is forgotten."""

    def settle(self) -> None:  # noqa: B027 - most devices need no time
        """Complete what takes time, such as an activation, at once; for the state before the start of the testbench."""

    def wire(self, table: int, address: int, values: Sequence[int]) -> None:  # noqa: B027 - most have no terminals
        """Set inputs to which sensors are wired; ``table``: 2 for discrete inputs, 4 for input registers."""

    @property
    def due(self) -> int | None:
        """Time at which it does something without a message, µs; None: it does not."""
        return None

    def advance(self, at: int) -> None:  # noqa: B027 - most devices do nothing by themselves
        """Process what happened by ``at``; the physics has reached that time."""

    def hear(self, at: int) -> None:  # noqa: B027 - of most devices no source says that they watch their messages
        """Process that an undamaged message to this unit arrived."""

    @abstractmethod
    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        """Return registers or bits; raises NoSuchRegisterError."""

    @abstractmethod
    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        """Execute a write; raises NoSuchRegisterError or BadValueError, and then nothing has changed."""

    def answer(self, unit: int, pdu: bytes, at: int) -> bytes:
        """Execute a request and return the answer as an RTU frame."""
        self.advance(at)
        self.hear(at)
        return self._executed(unit, pdu, at)

    def _executed(self, unit: int, pdu: bytes, at: int) -> bytes:
        function = pdu[0]
        if function not in self.functions:
            return refusal(unit, function, ILLEGAL_FUNCTION)
        request = parsed(unit, pdu)
        if request is None or not 1 <= request.size <= _MOST.get(function, 1):
            return refusal(unit, function, ILLEGAL_VALUE)
        try:
            if function in READS:
                found = self.read(function, request.address, request.size, at)
                return read_answer(request, found)
            values = request.values or ()
            if function == 22:
                (was,), (mask, bits) = self.read(3, request.address, 1, at), values
                values = (was & mask | bits & ~mask & 0xFFFF,)
            if request.read is None:
                self.write(request.address, values, at, coils=function in (5, 15))
                return done_answer(request)
            address, size = request.read
            if not 1 <= size <= _MOST[3]:
                raise BadValueError
            self.read(3, address, size, at)  # a request with a wrong read writes nothing
            self.write(request.address, values, at, coils=False)
            return read_answer(request, self.read(3, address, size, at))
        except NoSuchRegisterError:
            return refusal(unit, function, ILLEGAL_ADDRESS)
        except BadValueError:
            return refusal(unit, function, ILLEGAL_VALUE)
