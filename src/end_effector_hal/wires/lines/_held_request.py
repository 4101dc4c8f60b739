"""Uses lines of the kernel through an inherited descriptor of their request.

libgpiod's Python API can make a request but cannot adopt one, so the two necessary calls are implemented here. Source:
linux/gpio.h, GPIO_V2_LINE_GET_VALUES_IOCTL, GPIO_V2_LINE_SET_VALUES_IOCTL, struct gpio_v2_line_values.
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
    """Replaces gpiod's ``LineRequest`` as far as needed: reads, writes, release.

    Args:
        fd: descriptor of a request for outputs.
        offsets: the lines of the request, in its order.
        value: gpiod's ``line.Value``.
    """

    def __init__(self, fd: int, offsets: Sequence[int], value: Any) -> None:
        self.fd, self._value = fd, value
        self._bits = {offset: 1 << index for index, offset in enumerate(offsets)}

    def get_values(self, offsets: Sequence[int]) -> list[Any]:
        """Return the values of these lines, in this order; raises OSError."""
        mask = sum(self._bits[offset] for offset in offsets)
        answer = fcntl.ioctl(self.fd, GET_VALUES, _VALUES.pack(0, mask))
        bits, _ = _VALUES.unpack(answer)
        value = self._value
        return [value.ACTIVE if bits & self._bits[offset] else value.INACTIVE for offset in offsets]

    def set_values(self, values: Mapping[int, Any]) -> None:
        """Write these lines at once; raises OSError."""
        active = [offset for offset, value in values.items() if value == self._value.ACTIVE]
        bits, mask = (sum(self._bits[offset] for offset in some) for some in (active, values))
        fcntl.ioctl(self.fd, SET_VALUES, _VALUES.pack(bits, mask))

    def release(self) -> None:
        """Release the lines; a second call has no effect."""
        if self.fd >= 0:
            os.close(self.fd)
            self.fd = -1
