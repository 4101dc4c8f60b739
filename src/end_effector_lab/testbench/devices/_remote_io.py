"""A station of remote inputs and outputs, as the standard (Modbus V1.1b3) describes its four tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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

    def hear(self, at: int) -> None:
        """Messages keep nothing alive."""

    def wire(self, table: int, address: int, values: Sequence[int]) -> None:
        self._tables[table][address : address + len(values)] = values

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        if address + size > SIZE:
            raise NoSuchRegisterError
        return tuple(self._tables[function][address : address + size])

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        if address + len(values) > SIZE:
            raise NoSuchRegisterError
        self._tables[COILS if coils else HOLDING][address : address + len(values)] = values
        for channel, value in enumerate(values, start=address) if coils else ():
            self._tell(channel, bool(value))
