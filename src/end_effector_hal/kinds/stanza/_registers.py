"""An output that is a register of a Modbus device: the values to write, and how the result is verified."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from ._base import BaseStanza, Name

Registers = Annotated[tuple[Annotated[int, Field(ge=0, le=0xFFFF)], ...], Field(strict=False, max_length=16)]
Steps = Annotated[tuple[Registers, ...], Field(strict=False, max_length=8)]


class Activation(BaseStanza):
    """The writes that a device needs before it obeys commands.

    The HAL makes these writes only at the beginning of a commanded activation or of a Drop.

    So nothing moves at a start, after a loss of power or after a fault. The activation is not done either while
    another actuator of the same unit may hold a part. `command_off` follows it, then `command_on`. A command with a
    bit that the last row sets would also activate the device: it is not written while `ready` is off.
    """

    address: Annotated[int | None, Field(ge=0, le=0xFFFF)] = Field(
        default=None, description="of the first register of each row; null: that of the output"
    )
    write: Steps = Field(description="rows of registers, written one after the other from `address` on")
    ready: Name = Field(
        description="bit channel: on while the device is activated; it is only done while off"
    )
    ready_within_s: Annotated[float, Field(ge=0.1, le=60)] = Field(
        default=4.0,
        description="time limit for `ready`, else the command is given up; less than timeout_s and release_s",
    )


class Handshake(BaseStanza):
    """How a device accepts written values: it sets a bit, and the master acknowledges that bit.

    The master writes `request`, the device turns `taken` on, the master writes `end`, the device turns `taken` off.
    Then the command is done.
    """

    address: Annotated[int | None, Field(ge=0, le=0xFFFF)] = Field(
        default=None, description="of `request` and `end`; null: that of the output"
    )
    request: Registers = Field(description="values that ask the device to take it, in one request")
    taken: Name = Field(description="bit channel: on while the device says that it has taken it")
    end: Registers = Field(description="values that end the handshake; as many")
    order: Literal["before", "after"] = Field(
        default="before",
        description="before: it hands over data, and the command is written when it is over; after: the command stands "
        "in its registers first, and the handshake has the device take it",
    )
    within_s: Annotated[float, Field(ge=0.05, le=60)] = Field(
        default=1.0,
        description="time limit for `taken` to turn on and off; then a grip is given up, and a release is repeated",
    )


class OppositeRegister(BaseStanza):
    """The second coil of a valve, at an address that is no neighbour of the first, or another bit.

    `command_on` makes a coil active and `command_off` inactive. A command first makes one coil inactive; the other
    becomes active only when the device has acknowledged that, so the two are never active together. After a write
    without an answer the command begins again.
    """

    address: Annotated[int, Field(ge=0, le=0xFFFF)] = Field(
        description="of its first register, on the unit of the output"
    )
    bitmask: Annotated[int | None, Field(ge=1, le=0xFFFF)] = Field(
        default=None, description="its bits; with `bitmask` of the output"
    )


class RegisterOutput(BaseStanza):
    """Registers or a coil of a Modbus device on the link, written by the line arbiter as the bus master."""

    link: Name | None = Field(
        default=None, description="name under `links` of the bus, where several of them are Modbus"
    )
    unit: Annotated[int, Field(ge=0, le=255)] = Field(
        default=1, description="address of the device on the bus"
    )
    address: Annotated[int, Field(ge=0, le=0xFFFF)] = Field(
        description="of the first register, as it stands on the wire, from 0 on (40001 in a manual is 0)"
    )
    register_type: Literal["holding", "coil"] = Field(
        default="holding",
        description="one register is written with function 6, several with 16; coils with 5 and 15",
    )
    use_write_multiple: bool = Field(
        default=False, description="one register or coil is written with function 16 or 15, too"
    )
    bitmask: Annotated[int | None, Field(ge=1, le=0xFFFF)] = Field(
        default=None,
        description="bits of one holding register that are this output; `command_on` and `command_off` are one value "
        "each, of these bits, and `verify` reads them back. Outputs of one register are written together; bits of no "
        "output are 0. null: whole registers",
    )
    use_mask_write: bool = Field(
        default=False,
        description="the bits are written alone, with function 22 (mask write register), if the device has it; the "
        "other bits stay as they are, and `verify` may be left out",
    )
    command_on: Registers = Field(description="values that make it grip, from `address` on, in one request")
    command_off: Registers = Field(description="values that make it release; as many")
    opposite: OppositeRegister | None = Field(
        default=None,
        description="absent: one coil, or two neighbours that `command_on` and `command_off` write together",
    )
    pulse_s: Annotated[float | None, Field(ge=0.01, le=2)] = Field(
        default=None,
        description="a command is active for so long, then zeros are written (with `opposite`, `command_off` to both): "
        "the two coils of a bistable valve, `command_on: [1, 0]` and `command_off: [0, 1]`; null: until the next "
        "command",
    )
    pause_s: Annotated[float | None, Field(ge=0.05, le=10)] = Field(
        default=None,
        description="after a pulse nothing is written for so long, and a command waits; null: no pause",
    )
    verify: Name | None = Field(
        default=None,
        description="bit channel: on while the device says that command_on is what it was told; null: it cannot be "
        "read back, so that after a start of the line arbiter the sensors decide, and in doubt it is active; it is "
        "also active for a program that has activated it and still runs, whatever the sensors show",
    )
    activation: Activation | None = Field(default=None, description="absent: it obeys from its start on")
    handshake: Handshake | None = Field(default=None, description="absent: what is written counts at once")
    acknowledge: Steps | None = Field(
        default=None,
        description="rows of registers that clear a fault of the device, from `address` on; a reset writes them, while "
        "no actuator of the unit may hold a part, and so does a Drop whose device may have one; null: nothing",
    )
    keep_alive_ms: Annotated[int | None, Field(ge=20, le=60_000)] = Field(
        default=None,
        description="time without a message after which the device considers the link lost; null: it never does",
    )
    on_link_loss: Literal["hold", "release", "keep", "undefined"] = Field(
        default="undefined",
        description="effect of a lost link, by its manual; hold: what is held stays held; keep: it stays as it was",
    )

    @property
    def rests(self) -> tuple[tuple[int, tuple[int, ...]], ...]:
        """Address and values of each write that ends a pulse."""
        if self.opposite is not None:
            return self.coil(first=True, active=False), self.coil(first=False, active=False)
        return ((self.address, (0,) * len(self.command_on)),)

    def coil(self, *, first: bool, active: bool) -> tuple[int, tuple[int, ...]]:
        """Return address and values that make the first or the second coil of a pair active or inactive."""
        own = self.opposite if self.opposite is not None and not first else self
        return own.address, _shifted(self.command_on if active else self.command_off, own.bitmask)

    def bitmask_at(self, address: int) -> int | None:
        """Return the bits that a write to one of its registers changes; None: all."""
        second = self.opposite is not None and address == self.opposite.address
        return self.opposite.bitmask if self.opposite is not None and second else self.bitmask

    @property
    def activation_bits(self) -> dict[int, int]:
        """The bits that the last row of its activation sets and the row before does not, by register."""
        if (activation := self.activation) is None:
            return {}
        before, last = ((0,) * len(activation.write[-1]), *activation.write)[-2:]
        start = self.address if activation.address is None else activation.address
        rows = enumerate(zip(before, last, strict=False), start)
        return {at: now & ~was for at, (was, now) in rows if now & ~was}

    @property
    def commands_activate(self) -> bool:
        """Whether a command has an activation bit, so that it would activate a device that is not active."""
        bits = self.activation_bits
        rows = [*enumerate(self.command_on, self.address), *enumerate(self.command_off, self.address)]
        return any(value & bits.get(at, 0) for at, value in rows)

    @property
    def output(self) -> str:
        """Name of this output among the outputs of the tool; it contains the address."""
        return output_name(self.unit, self.address, self.link, self.bitmask)

    @property
    def second_coil(self) -> str:
        """Name of the second coil of a pair; empty: there is none."""
        second = self.opposite
        return output_name(self.unit, second.address, self.link, second.bitmask) if second else ""

    def writes(self, level: bool) -> tuple[tuple[int, tuple[int, ...]], ...]:
        """Return address and values of each write of a level; of two coils, one is off before the other is on."""
        if self.opposite is None:
            return ((self.address, self.values(level)),)
        return self.coil(first=not level, active=False), self.coil(first=level, active=True)

    def values(self, level: bool) -> tuple[int, ...]:
        """Return the values to write for a level; with a bitmask the bits of the register, at their place."""
        return _shifted(self.command_on if level else self.command_off, self.bitmask)


def _shifted(row: tuple[int, ...], bitmask: int | None) -> tuple[int, ...]:
    return tuple(value << lowest_bit(bitmask) for value in row) if bitmask else row


def lowest_bit(bitmask: int) -> int:
    """Return the place of the lowest bit of a mask."""
    return (bitmask & -bitmask).bit_length() - 1


def output_name(unit: int, address: int, link: str | None = None, bitmask: int | None = None) -> str:
    """Return the name of an output on a bus; ``link``: the bus, if the description names it."""
    bit = f".{lowest_bit(bitmask)}" if bitmask else ""
    return f"modbus:{link + ':' if link else ''}{unit}/0x{address:04X}{bit}"


def with_line(given: Any) -> Any:
    """Return the keys of an actuator; if its output is on the bus, `line` is added with the output's name."""
    if not isinstance(given, dict) or not isinstance(given.get("modbus"), dict):
        return given
    unit, address = given["modbus"].get("unit", 1), given["modbus"].get("address", 0)
    link, bitmask = given["modbus"].get("link"), given["modbus"].get("bitmask")
    known = type(unit) is int and type(address) is int and (link is None or isinstance(link, str))
    known &= bitmask is None or (type(bitmask) is int and bitmask > 0)
    name = output_name(unit, address, link, bitmask) if known else "modbus"
    return {**given, "line": name[:64]}
