"""Lines of the kernel by the descriptor of their request alone.

libgpiod's Python API makes a request and cannot take one over, so the two calls that are needed stand here.
Source: linux/gpio.h, GPIO_V2_LINE_GET_VALUES_IOCTL, GPIO_V2_LINE_SET_VALUES_IOCTL, struct gpio_v2_line_values.
"""

from __future__ import annotations

import fcntl
import os
import struct
from collections.abc import Mapping, Sequence
from typing import Any

GET_VALUES, SET_VALUES = 0xC010B40E, 0xC010B40F
_VALUES = struct.Struct("=QQ")  # bits, mask: a bit for each line in the order of the request


class HeldRequest:
    """What is used of gpiod's ``LineRequest``: reads, writes, gives back.

    Args:
        fd: of a request for outputs.
        offsets: its lines, in its order.
        value: gpiod's ``line.Value``.
    """

    def __init__(self, fd: int, offsets: Sequence[int], value: Any) -> None:
        self.fd, self._value = fd, value
        self._bits = {offset: 1 << index for index, offset in enumerate(offsets)}

    def get_values(self, offsets: Sequence[int]) -> list[Any]:
        """Of these lines, in this order; raises OSError."""
        mask = sum(self._bits[offset] for offset in offsets)
        answer = fcntl.ioctl(self.fd, GET_VALUES, _VALUES.pack(0, mask))
        bits, _ = _VALUES.unpack(answer)
        value = self._value
        return [value.ACTIVE if bits & self._bits[offset] else value.INACTIVE for offset in offsets]

    def set_values(self, values: Mapping[int, Any]) -> None:
        """At once; raises OSError."""
        active = [offset for offset, value in values.items() if value == self._value.ACTIVE]
        bits, mask = (sum(self._bits[offset] for offset in some) for some in (active, values))
        fcntl.ioctl(self.fd, SET_VALUES, _VALUES.pack(bits, mask))

    def release(self) -> None:
        """Give it back; nothing happens the second time."""
        if self.fd >= 0:
            os.close(self.fd)
            self.fd = -1
