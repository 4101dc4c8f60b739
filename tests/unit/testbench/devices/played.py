"""A modelled unit with its physics, in virtual time."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.devices import UnitModel, sealed
from end_effector_lab.testbench.physics import Device

UNIT = 9
STEP_US = 10_000


class PlayedUnit:
    """Requests go to the unit at once; time goes on between them."""

    def __init__(self, model: type[UnitModel], devices: Mapping[int, Device]) -> None:
        self.at, self.devices = 0, devices
        self.told: list[tuple[int, bool]] = []
        self.model = model(devices, self._tell)
        self.model.power_up(0)

    def _tell(self, channel: int, level: bool) -> None:
        self.told.append((channel, level))
        if channel in self.devices:
            self.devices[channel].command(level, self.at)

    def run(self, seconds: float) -> None:
        """Let time go on without a message."""
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            self.at = min(self.at + STEP_US, until)
            for device in self.devices.values():
                device.advance(self.at)
            self.model.advance(self.at)

    def ask(self, pdu: str, unit: int = UNIT) -> str:
        """Send a PDU in hexadecimal digits; return that of the answer, empty without one."""
        answer = self.model.answer(unit, bytes.fromhex(pdu), self.at)
        if not answer:
            return ""
        assert answer == sealed(answer[:-2])
        assert answer[0] == unit
        return answer[1:-2].hex(" ").upper()

    def words(self, address: int, size: int, function: int = 4) -> list[int]:
        """Return registers that are read from the unit."""
        answer = bytes.fromhex(self.ask(f"{function:02X} {address:04X} {size:04X}"))
        assert answer[:2] == bytes([function, 2 * size]), answer.hex()
        return [int.from_bytes(answer[i : i + 2], "big") for i in range(2, len(answer), 2)]

    def write(self, address: int, *values: int) -> None:
        """Write registers with function 16."""
        data = b"".join(value.to_bytes(2, "big") for value in values).hex()
        head = f"10 {address:04X} {len(values):04X}"
        assert self.ask(f"{head} {2 * len(values):02X} {data}") == " ".join(
            f"{byte:02X}" for byte in bytes.fromhex(head)
        )
