"""The ports over which the testbench communicates: serial devices and ptys."""

from __future__ import annotations

import os
import select
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import serial

from end_effector_hal.errors import LinkError
from end_effector_hal.wires.link import PtyPair, open_port

_BITS_PER_BYTE = 10  # 8N1


class Port(Protocol):
    """Sends frames, and receives requests."""

    @property
    def text(self) -> str:
        """Name of the port for people."""
        ...

    def open(self) -> None:
        """Open the port; raises LinkError."""
        ...

    def send(self, data: bytes) -> int:
        """Send without waiting for a reader; bytes that do not fit are lost, as on a wire.

        Returns:
            Time that the wire needs for the data, µs.

        Raises:
            LinkError: the port has gone.
        """
        ...

    def cut(self, data: bytes) -> None:
        """Send the first half, and reset the connection if the port has one; raises LinkError like `send`."""
        ...

    def refuse(self, *, refuses: bool) -> None:
        """Refuse connections from now on, and reset those there are; or accept them again."""
        ...

    def receive(self, wait_s: float) -> bytes:
        """Return the bytes that arrived, after at most ``wait_s``; b"" if there are none; raises LinkError like
        `send`.
        """
        ...

    def close(self) -> None:
        """Close the port."""
        ...


class WithoutConnections:
    """The part of a `Port` on a wire that concerns connections: it has none."""

    def cut(self: Port, data: bytes) -> None:
        self.send(data[: len(data) // 2])

    def refuse(self, *, refuses: bool) -> None:
        pass


class SerialPort(WithoutConnections):
    """A serial device as a port.

    Args:
        path: path of the device.
        baudrate, parity, stopbits: settings of the device, with 8 data bits.
    """

    def __init__(self, path: str, baudrate: int, parity: str = "N", stopbits: int = 1) -> None:
        self.text = path
        self._baudrate, self._parity, self._stopbits = baudrate, parity, stopbits
        self._serial: serial.Serial | None = None

    def open(self) -> None:
        self._serial = open_port(
            self.text, self._baudrate, parity=self._parity, stopbits=self._stopbits, write_timeout_s=0.5
        )

    def send(self, data: bytes) -> int:
        if self._serial is not None:
            try:
                self._serial.write(data)
            except serial.SerialTimeoutException:
                pass  # flow control holds it back: lost
            except OSError as error:
                raise LinkError(f"the port has gone: {error}.", where=self.text) from error
        return len(data) * _BITS_PER_BYTE * 1_000_000 // self._baudrate

    def receive(self, wait_s: float) -> bytes:
        if self._serial is None:
            return b""
        try:
            return os.read(fd, 4096) if _readable(fd := self._serial.fileno(), wait_s) else b""
        except OSError as error:
            raise LinkError(f"the port has gone: {error}.", where=self.text) from error

    def close(self) -> None:
        if self._serial is not None:
            self._serial.close()


class PtyPort(WithoutConnections):
    """A new pty, reached by a symbolic link.

    Args:
        link: path of the link.
    """

    def __init__(self, link: str) -> None:
        self.text = link
        self._pair: PtyPair | None = None

    def open(self) -> None:
        with suppress(OSError):  # then the pair says why
            Path(self.text).parent.mkdir(parents=True, exist_ok=True)
        self._pair = PtyPair(self.text)

    def send(self, data: bytes) -> int:
        """Send the data; a pty needs no time for it."""
        if self._pair is not None:
            self._pair.write(data)
        return 0

    def receive(self, wait_s: float) -> bytes:
        return self._pair.read() if self._pair is not None and _readable(self._pair.fileno(), wait_s) else b""

    def close(self) -> None:
        if self._pair is not None:
            self._pair.close()


def _readable(fd: int, wait_s: float) -> bool:
    return bool(select.select([fd], [], [], wait_s)[0])
