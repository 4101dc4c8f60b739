"""A device at the far end of a Modbus line: the frames of RTU, and the registers that a description commands.

The frames follow the table of the standard and share no code with the HAL; the registers work for any tool.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from end_effector_hal.kinds.stanza import Activation, Handshake, RegisterOutput
from end_effector_hal.signals import Value

ILLEGAL_VALUE = 3
LONGEST = 256


def crc16(data: bytes) -> bytes:
    """Return the CRC-16/MODBUS, low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return bytes([crc & 0xFF, crc >> 8])


def sealed(body: bytes) -> bytes:
    """Return a frame with its CRC."""
    return body + crc16(body)


class RegisterRequest(NamedTuple):
    """One request; ``values`` is None for a read of ``size`` registers or coils."""

    unit: int
    function: int
    address: int
    size: int
    values: tuple[int, ...] | None = None


def read_request(frame: bytes) -> RegisterRequest | None:
    """Parse a complete frame; return None if it is not a request, or damaged."""
    if len(frame) < 8 or len(frame) > LONGEST or crc16(frame[:-2]) != frame[-2:]:
        return None
    unit, function = frame[0], frame[1]
    address, word = int.from_bytes(frame[2:4], "big"), int.from_bytes(frame[4:6], "big")
    if function in (1, 2, 3, 4) and len(frame) == 8:
        return RegisterRequest(unit, function, address, word)
    if function == 6 and len(frame) == 8:
        return RegisterRequest(unit, function, address, 1, (word,))
    if function == 5 and len(frame) == 8 and word in (0, 0xFF00):
        return RegisterRequest(unit, function, address, 1, (int(word == 0xFF00),))
    data = frame[7:-2]
    if function == 16 and frame[6] == 2 * word == len(data):
        words = tuple(int.from_bytes(data[2 * i : 2 * i + 2], "big") for i in range(word))
        return RegisterRequest(unit, function, address, word, words)
    if function == 15 and frame[6] == -(-word // 8) == len(data):
        bits = tuple(data[i // 8] >> i % 8 & 1 for i in range(word))
        return RegisterRequest(unit, function, address, word, bits)
    return None


def done_answer(request: RegisterRequest) -> bytes:
    """Return the answer to a write that was executed."""
    head = bytes([request.unit, request.function]) + request.address.to_bytes(2, "big")
    if request.function == 5:
        return sealed(head + (b"\xff\x00" if request.values == (1,) else b"\x00\x00"))
    if request.function == 6:
        return sealed(head + (request.values or (0,))[0].to_bytes(2, "big"))
    return sealed(head + request.size.to_bytes(2, "big"))


def exception_answer(request: RegisterRequest, code: int) -> bytes:
    """Return the answer to a request that cannot be executed."""
    return sealed(bytes([request.unit, request.function | 0x80, code]))


class CommandedRegisters:
    """Executes command_on and command_off of every output whose unit is activated; refuses other writes.

    A device that is not active activates itself when its activation bits rise, even if another command writes them;
    the activation moves it, so it releases. Its activation bits are those that the last row of its activation sets.

    With a handshake, a command takes effect only after the handshake before it, or with the handshake after it, as the
    description says.

    An output whose `on_link_loss` is release switches off when its unit received no request for `keep_alive_ms`.

    Args:
        outputs: the outputs of one bus, by name.
        obey: called with name and level of an output that was commanded.
    """

    def __init__(self, outputs: Mapping[str, RegisterOutput], obey: Callable[[str, bool], None]) -> None:
        self._outputs, self._obey = outputs, obey
        self._levels: dict[str, bool] = {}
        self._activated: set[int] = set()
        self._registers: dict[tuple[int, int], int] = {}
        """Registers with activation bits, as they were written."""
        self._heard_at: dict[int, int] = {}
        self._taken: set[str] = set()
        self._handed: set[str] = set()
        """Outputs with a completed handshake, which is valid for one command."""
        self._staged: dict[str, bool] = {}
        """Commands that wait for their handshake."""

    def start(self, levels: dict[str, bool], at: int) -> None:
        """Set the initial state at ``at`` (µs); the unit of an active output counts as activated."""
        self._levels = {name: levels.get(name, False) for name in self._outputs}
        self._activated = {self._outputs[name].unit for name, level in self._levels.items() if level}
        self._registers = {
            (each.unit, address): bits if each.unit in self._activated else 0
            for each in self._outputs.values()
            for address, bits in each.activation_bits.items()
        }
        self._heard_at = {each.unit: at for each in self._outputs.values()}
        self._taken, self._handed, self._staged = set(), set(), {}

    @property
    def due(self) -> int | None:
        """Time at which `advance` must be called, µs; None: no output switches off by itself."""
        return min(map(self._until, self._losing()), default=None)

    def advance(self, at: int) -> None:
        """Switch off outputs whose unit received no request for too long by ``at`` (µs)."""
        for name in self._losing():
            if self._until(name) <= at:
                self._levels[name] = False
                self._obey(name, False)

    def hear(self, frame: bytes, at: int) -> None:
        """Record a request at ``at`` (µs), which keeps its unit alive."""
        if (request := read_request(frame)) is not None:
            self._heard_at[request.unit] = at

    def _losing(self) -> list[str]:
        """Return the active outputs that switch off when requests stop."""
        return [
            name
            for name, each in self._outputs.items()
            if self._levels.get(name) and each.on_link_loss == "release" and each.keep_alive_ms is not None
        ]

    def _until(self, name: str) -> int:
        each = self._outputs[name]
        return self._heard_at[each.unit] + (each.keep_alive_ms or 0) * 1000

    def answer(self, frame: bytes) -> bytes | None:
        """Return the answer to a write; None if the frame is not a write, or not for these units."""
        request = read_request(frame)
        if request is None or request.values is None:
            return None
        if request.unit not in {each.unit for each in self._outputs.values()}:
            return None
        return done_answer(request) if self._done(request) else exception_answer(request, ILLEGAL_VALUE)

    @property
    def values(self) -> dict[str, Value]:
        """Values of the channels of `verify`, `ready` and `taken`."""
        shown: dict[str, Value] = {}
        for name, each in self._outputs.items():
            if each.activation:
                shown[each.activation.ready] = each.unit in self._activated
            if each.verify:
                shown[each.verify] = self._levels.get(name, False)
            if each.handshake:
                shown[each.handshake.taken] = name in self._taken
        return shown

    def _done(self, request: RegisterRequest) -> bool:
        values, coils, left = request.values or (), request.function in (5, 15), set(range(request.size))
        self._rise(request.unit, request.address, () if coils else values)
        for name, each in self._outputs.items():
            start = each.address - request.address
            if each.unit != request.unit or coils != (each.register_type == "coil"):
                continue
            if self._shakes(name, request.address, values):
                left.clear()
            if each.acknowledge and start == 0 and values in each.acknowledge:
                left.clear()
            activation = each.activation
            if activation and values in activation.write and request.address == _address(activation, each):
                left.clear()
                if values == activation.write[-1]:
                    self._activate(each.unit)
                else:
                    self._activated.discard(each.unit)
                continue
            if start < 0:
                continue
            row = values[start : start + len(each.command_on)]
            if row in (each.command_on, each.command_off):
                left -= set(range(start, start + len(row)))
                if each.activation is None or each.unit in self._activated:
                    self._command(name, row == each.command_on)
        return not left

    def _rise(self, unit: int, address: int, values: tuple[int, ...]) -> None:
        """Store written activation bits, and activate the unit if they rise."""
        for each in self._outputs.values():
            bits = {(unit, at): most for at, most in each.activation_bits.items() if each.unit == unit}
            were = all(self._registers[at] & most == most for at, most in bits.items())
            written = {(unit, address + i): value for i, value in enumerate(values)}
            self._registers |= {at: value for at, value in written.items() if at in bits}
            if bits and not were and all(self._registers[at] & most == most for at, most in bits.items()):
                self._activate(unit)

    def _activate(self, unit: int) -> None:
        for name, each in self._outputs.items():
            if each.unit == unit and unit not in self._activated:
                self._switch(name, level=False)
        self._activated.add(unit)

    def _shakes(self, name: str, address: int, values: tuple[int, ...]) -> bool:
        """Execute a step of the output's handshake; return whether the write is one."""
        each, handshake = self._outputs[name], self._outputs[name].handshake
        if handshake is None or address != _address(handshake, each):
            return False
        if values == handshake.request:
            self._taken.add(name)
            if name in self._staged:
                self._switch(name, self._staged.pop(name))
        elif values == handshake.end and name in self._taken:
            self._taken.remove(name)
            self._handed.add(name)
        return values in (handshake.request, handshake.end)

    def _command(self, name: str, level: bool) -> None:
        handshake = self._outputs[name].handshake
        if handshake is None or (handshake.order == "before" and name in self._handed):
            self._handed.discard(name)
            self._switch(name, level)
        elif handshake.order == "after":
            self._staged[name] = level

    def _switch(self, name: str, level: bool) -> None:
        self._levels[name] = level
        self._obey(name, level)


def _address(part: Activation | Handshake, output: RegisterOutput) -> int:
    return output.address if part.address is None else part.address
