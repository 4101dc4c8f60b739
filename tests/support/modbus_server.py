"""A remote I/O station of pymodbus in a process of its own: ``python -m tests.support.modbus_server socket 1 2``.

The arguments are the frames (``socket``: Modbus TCP, ``rtu``: RTU over TCP) and the units; it prints its port number.
Behind every unit: coil 0 moves a lift or unlocks a tool changer (discrete inputs 0: down, 1: up), coil 1 a cup (input
register 0: -60 kPa); a tool is always there and in its stand (discrete inputs 2 and 3).
"""

from __future__ import annotations

import asyncio
import sys
from typing import Any

from pymodbus import FramerType
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

READ_INPUTS, READ_REGISTERS, WRITE_COIL, WRITE_COILS = 2, 4, 5, 15
HELD = 0x10000 - 600
"""What the pressure shows while the cup holds, 0.1 kPa in two's complement."""


class Physics:
    """The lift and the cup of each unit, by what is written to its coils and read from its inputs."""

    def __init__(self) -> None:
        self._coils: dict[tuple[int, int], bool] = {}

    def traced(self, sending: bool, pdu: Any) -> Any:
        """See a request, or change an answer, on its way."""
        unit = pdu.dev_id
        if not sending and pdu.function_code in (WRITE_COIL, WRITE_COILS):
            self._coils |= {(unit, pdu.address + i): bool(bit) for i, bit in enumerate(pdu.bits)}
        lift, cup = (self._coils.get((unit, coil), False) for coil in (0, 1))
        if sending and pdu.function_code == READ_INPUTS:
            pdu.bits = [lift, not lift, True, True, *pdu.bits[4:]]
        if sending and pdu.function_code == READ_REGISTERS:
            pdu.registers = [HELD if cup else 0, *pdu.registers[1:]]
        return pdu


def station(unit: int) -> SimDevice:
    """One unit with 16 values in each table."""
    bits = [[SimData(0, count=16, values=False, datatype=DataType.BITS)] for _ in range(2)]
    words = [[SimData(0, count=16, values=0, datatype=DataType.REGISTERS)] for _ in range(2)]
    return SimDevice(unit, simdata=(*bits, *words))


async def serve(framer: FramerType, units: list[int]) -> None:
    """Serve until the process is killed."""
    server = ModbusTcpServer(
        [station(unit) for unit in units],
        framer=framer,
        address=("127.0.0.1", 0),
        ignore_missing_devices=True,
        trace_pdu=Physics().traced,
    )
    await server.listen()
    sys.stdout.write(f"{server.transport.sockets[0].getsockname()[1]}\n")
    sys.stdout.flush()
    await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(serve(FramerType(sys.argv[1]), [int(each) for each in sys.argv[2:]]))
