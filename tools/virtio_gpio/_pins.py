"""The GPIO chip: it answers requests of the guest's driver and reports levels; no I/O."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from enum import IntEnum

OUT = 1
_OK, _ERROR = 0, 1
_REQUEST = struct.Struct("<HHI")


class Request(IntEnum):
    """Types of requests (VIRTIO_GPIO_MSG_*)."""

    NAMES = 1
    GET_DIRECTION = 2
    SET_DIRECTION = 3
    GET_VALUE = 4
    SET_VALUE = 5


class Pins:
    """Lines of a virtio GPIO chip; a line that is not an output is low.

    Args:
        names: its lines; the guest uses these names.
        on_level: called at each change of a pin's level, before the guest gets its answer.
    """

    def __init__(self, names: Sequence[str], on_level: Callable[[str, bool], None]) -> None:
        self.names = tuple(names)
        self._on_level = on_level
        self._directions = [0] * len(self.names)
        self._values = [False] * len(self.names)

    @property
    def levels(self) -> dict[str, bool]:
        return {name: self._level(offset) for offset, name in enumerate(self.names)}

    @property
    def config(self) -> bytes:
        """Configuration of the device: number of lines, length of the names."""
        return struct.pack("<HxxI", len(self.names), len(self._text))

    def answer(self, request: bytes) -> bytes:
        """Return a status byte and a value, or all names, as the driver expects them."""
        if len(request) < _REQUEST.size:
            return bytes([_ERROR, 0])
        kind, offset, value = _REQUEST.unpack_from(request)
        if kind == Request.NAMES:
            return bytes([_OK]) + self._text
        if offset >= len(self.names):
            return bytes([_ERROR, 0])
        if kind == Request.GET_DIRECTION:
            return bytes([_OK, self._directions[offset]])
        if kind == Request.GET_VALUE:
            return bytes([_OK, self._level(offset)])
        if kind == Request.SET_DIRECTION and value in (0, 1, 2):
            self._change(offset, value, self._values[offset] and value == OUT)
            return bytes([_OK, 0])
        if kind == Request.SET_VALUE and value in (0, 1):
            self._change(offset, self._directions[offset], bool(value))
            return bytes([_OK, 0])
        return bytes([_ERROR, 0])

    def power_off(self) -> None:
        """Switch all lines off after the guest has disconnected."""
        for offset in range(len(self.names)):
            self._change(offset, 0, value=False)

    @property
    def _text(self) -> bytes:
        return b"".join(name.encode() + b"\0" for name in self.names)

    def _level(self, offset: int) -> bool:
        return self._directions[offset] == OUT and self._values[offset]

    def _change(self, offset: int, direction: int, value: bool) -> None:
        before = self._level(offset)
        self._directions[offset], self._values[offset] = direction, value
        if self._level(offset) != before:
            self._on_level(self.names[offset], not before)
