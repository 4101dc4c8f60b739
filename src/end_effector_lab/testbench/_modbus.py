"""Devices without a model of their own: registers that behave as the description of any tool says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from end_effector_hal.kinds.stanza import Activation, Handshake, RegisterOutput
from end_effector_hal.signals import Value

from .devices import ILLEGAL_VALUE, RegisterRequest, done_answer, exception_answer, read_request

MASK_WRITE = 22


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
        rows: what makes an output active beside its own command_on: the values of parts, by name.
    """

    def __init__(
        self,
        outputs: Mapping[str, RegisterOutput],
        obey: Callable[[str, bool], None],
        rows: Mapping[str, Collection[tuple[int, ...]]] | None = None,
    ) -> None:
        self._outputs, self._obey = outputs, obey
        self._active = {
            name: {each.values(level=True), *(rows or {}).get(name, ())} for name, each in outputs.items()
        }
        self._levels: dict[str, bool] = {}
        self._activated: set[int] = set()
        self._registers: dict[tuple[int, int], int] = {}
        """Registers with activation bits, as they were written."""
        self._heard_at: dict[int, int] = {}
        self._coils: dict[tuple[str, bool], bool] = {}
        """Coils of pairs by output, the first or the second one, as they were written."""
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
        self._taken, self._handed, self._staged, self._coils = set(), set(), {}, {}

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
        written = 0xFFFF
        if request.function == MASK_WRITE:
            keeps, bits = values
            values, written = (bits,), ~keeps & 0xFFFF
        self._rise(request.unit, request.address, () if coils or written != 0xFFFF else values)
        for name, each in self._outputs.items():
            start = each.address - request.address
            if each.unit != request.unit or coils != (each.register_type == "coil"):
                continue
            if each.opposite is not None:
                left -= self._pair(name, request.address, values, written)
                continue
            if not (each.bitmask or 0xFFFF) & written:
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
            if each.bitmask:  # an output that has not changed is not commanded again
                row = tuple(value & each.bitmask for value in row)
            if (
                each.pulse_s and (each.address, row) in each.rests
            ):  # the valve stays where the pulse has moved it
                left -= set(range(start, start + len(row)))
            level = row in self._active[name]
            if level or row == each.values(level=False):
                left -= set(range(start, start + len(row)))
                if each.bitmask and level is self._levels.get(name):
                    continue
                if each.activation is None or each.unit in self._activated:
                    self._command(name, level)
        return not left

    def _pair(self, name: str, address: int, values: tuple[int, ...], written: int) -> set[int]:
        """Write to a pair of coils, and return the places of its registers; the valve stays where one coil alone has
        moved it.
        """
        each, found = self._outputs[name], set[int]()
        for first in (True, False):
            own, on = each.coil(first=first, active=True)
            bitmask, start = each.bitmask_at(own) or 0xFFFF, own - address
            row = tuple(value & bitmask for value in values[max(start, 0) : start + len(on)])
            active = {on: True, each.coil(first=first, active=False)[1]: False}.get(row)
            if active is None or start < 0 or not bitmask & written:
                continue
            found |= set(range(start, start + len(on)))
            self._coils[name, first] = active
            if active and not self._coils.get((name, not first)):
                self._switch(name, level=first)
        return found

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
