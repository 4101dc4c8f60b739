"""Stations of remote inputs and outputs.

Sources: Modbus application protocol V1.1b3 for the four tables; WAGO, manual of the 750-843, page 167; Advantech,
manual of the ADAM-4000 series, page G-11. Assumed, as no source says it: that outputs are off after power returns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from end_effector_lab.testbench.physics import Device

from ._unit import NoSuchRegisterError, Tell, UnitModel

SIZE = 512
"""Size of each table."""
COILS, DISCRETE_INPUTS, HOLDING, INPUTS = 1, 2, 3, 4


class RemoteIo(UnitModel):
    """Coils, discrete inputs, holding and input registers; the coils of actuators drive them.

    All outputs are off after its power returns. It watches no messages.
    """

    name = "remote-io"
    functions = frozenset({1, 2, 3, 4, 5, 6, 15, 16, 22, 23})
    physics = Device
    coils: ClassVar[range] = range(SIZE)
    """The coils that it has."""

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._tables = {table: [0] * SIZE for table in (COILS, DISCRETE_INPUTS, HOLDING, INPUTS)}

    @staticmethod
    def channel_of(address: int) -> int:
        return address

    def power_up(self, at: int) -> None:
        driven = [channel for channel, coil in enumerate(self._tables[COILS]) if coil]
        self._tables |= {COILS: [0] * SIZE, HOLDING: [0] * SIZE}
        for channel in driven:
            self._tell(channel, False)

    def wire(self, table: int, address: int, values: Sequence[int]) -> None:
        self._tables[table][address : address + len(values)] = values

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        self._check(address, size, coils=function == COILS)
        return tuple(self._tables[function][address : address + size])

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        self._check(address, len(values), coils=coils)
        self._tables[COILS if coils else HOLDING][address : address + len(values)] = values
        for channel, value in enumerate(values, start=address) if coils else ():
            self._tell(channel, bool(value))

    def _check(self, address: int, size: int, *, coils: bool) -> None:
        there = self.coils if coils else range(SIZE)
        if address not in there or address + size - 1 not in there:
            raise NoSuchRegisterError


class Wago750(RemoteIo):
    """A coupler of WAGO's system 750 with 16 digital outputs, which are read back from 0x0200 on."""

    name = "wago-750"
    coils = range(16)
    read_back: ClassVar[int] = 0x0200

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        if function == COILS and address >= self.read_back:
            address -= self.read_back
        return super().read(function, address, size, at)


class Adam4056(RemoteIo):
    """An ADAM-4056SO: twelve outputs, the coils 16 to 27."""

    name = "advantech-adam-4056so"
    functions = frozenset({1, 5, 15})
    coils = range(16, 28)
