"""Assigns sources to the signals of a new tool: channels of its own in a declared frame, or inputs of the board."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from end_effector_hal.description import ToolChanger as ChangerStanza
from end_effector_hal.kinds import DeviceKind
from end_effector_hal.kinds.stanza import NO_CHANNEL
from end_effector_hal.signals import Kind

BOARD = "none"
LINKS = ("text", "json", "binary", "modbus", BOARD)
"""What carries the signals: a frame that is declared, or `BOARD`, the inputs of the board."""
CHANGER_DEFAULTS = tuple(str(ChangerStanza.model_fields[key].default) for key in ChangerStanza.BITS)


@dataclass
class NewChannels:
    """The signals of a tool, in the order of their channels.

    Attributes:
        carried: the kind of every channel, by name.
        given: for each actuator, the channel of each of its keys.
    """

    carried: dict[str, Kind] = field(default_factory=dict)
    given: dict[str, dict[str, str]] = field(default_factory=dict)


def new_channels(
    actuators: Sequence[tuple[str, DeviceKind[Any]]], *, on_board: bool, tool_changer: bool
) -> NewChannels:
    """Return a signal for every sensor that can confirm an actuator or the tool changer.

    A kind that a pressure confirms gets only the pressure, if the link carries pressures; any other kind gets its
    switches.
    """
    found = NewChannels()
    for name, kind in actuators:
        pressures = [each for each in kind.channels if each.carries is Kind.PRESSURE and each.confirms]
        wanted = kind.channels if on_board or not pressures else pressures
        found.given[name] = {each.key: NO_CHANNEL for each in kind.channels}
        for each in wanted:
            if each.carries is Kind.BIT or not on_board:
                own = each.carries is Kind.BIT or name in CHANGER_DEFAULTS
                channel = f"{name}_{each.meaning}" if own else name
                found.carried[channel] = each.carries
                found.given[name][each.key] = channel
    if tool_changer:
        found.carried |= dict.fromkeys(CHANGER_DEFAULTS, Kind.BIT)
    return found


def frame_line(link: str, channels: NewChannels) -> str:
    """Return the line of the declared frame that carries the channels of a link: text, json, binary or modbus."""
    match link:
        case "text":
            return (
                '  frame: {text: {start: "$", separator: ",", checksum: xor8}}   # $1,2.5,...*hh, a line each'
            )
        case "json":
            return '  frame: {json: {}}                  # {"cup": -62.4, "part": true}, a line each'
        case "binary":
            length = 2 * _count(channels, Kind.PRESSURE) + -(-_count(channels, Kind.BIT) // 8)
            return f"  frame: {{record: {{framing: cobs, length: {length}, checksum: crc16-modbus}}}}"
    return "  frame: {modbus: {}}                # the HAL asks, the devices answer"


def channel_lines(link: str, channels: NewChannels) -> Iterator[str]:
    """Yield the lines of the stanza ``channels`` with the place of every channel in the frame of its link."""
    yield ""
    yield "channels:                          # yours: where each signal stands; docs/reference/channels.md"
    place = {
        "text": _text,
        "json": _json(channels),
        "binary": _binary(channels),
        "modbus": _modbus(),
        BOARD: _board(),
    }[link]
    for number, (name, kind) in enumerate(channels.carried.items(), start=1):
        more = "" if kind is Kind.BIT else ", unit: kPa, scale: 0.1"
        yield f"  {name}: {{{place(number, kind)}{more}}}"


def _count(channels: NewChannels, kind: Kind) -> int:
    return sum(each is kind for each in channels.carried.values())


Place = Callable[[int, Kind], str]


def _text(number: int, kind: Kind) -> str:
    decimals = "" if kind is Kind.BIT else ", decimals: 0"
    return f"text: {{field: {number}{decimals}}}"


def _json(channels: NewChannels) -> Place:
    keys = [*channels.carried]
    return lambda number, _: f"json: {{key: {keys[number - 1]}}}"


def _binary(channels: NewChannels) -> Place:
    """Return a function that places pressures first, 16 bits each, then the bits, eight per byte."""
    first = 2 * _count(channels, Kind.PRESSURE)
    return _counted(
        lambda index: f"record: {{byte: {2 * index}, value_type: int16}}",
        lambda index: f"record: {{byte: {first + index // 8}, bitmask: {1 << index % 8}}}",
    )


def _modbus() -> Place:
    return _counted(
        lambda index: f"modbus: {{unit: 1, address: {index}, register_type: input, value_type: int16}}",
        lambda index: f"modbus: {{unit: 1, address: {index}, register_type: discrete_input}}",
    )


def _counted(pressure: Callable[[int], str], bit: Callable[[int], str]) -> Place:
    """Return a function that numbers pressures and bits separately, both from 0."""
    written, numbers = {Kind.PRESSURE: pressure, Kind.BIT: bit}, {Kind.PRESSURE: count(), Kind.BIT: count()}
    return lambda _, kind: written[kind](next(numbers[kind]))


def _board() -> Place:
    return lambda number, _: f"digital: {{line: INPUT_{number}, bias: pull_up, debounce_ms: 2}}, invert: true"
