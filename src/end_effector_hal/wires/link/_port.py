"""Opens the port of a link, and explains in a sentence why it cannot be opened."""

from __future__ import annotations

import errno
import glob
import os
import re
from contextlib import suppress
from typing import TYPE_CHECKING, Protocol

from end_effector_hal.description import network_address
from end_effector_hal.errors import LinkBusyError, LinkError
from end_effector_hal.wires._claim import Holder, holders_of, holders_of_address

from ._network import NetworkPort
from ._telnet import SerialSettings

if TYPE_CHECKING:
    import serial

_USUAL = ("/dev/verdin-uart*", "/dev/tty[A-Z]*[0-9]", "/dev/ttymxc*", "/dev/serial[0-9]")


READ_BYTES = 4096


class OpenPort(Protocol):
    """An open source of bytes: a serial port, or a connection to the process that has the port."""

    def fileno(self) -> int:
        """Return the descriptor for select; available data can be read without waiting."""
        ...

    def close(self) -> None:
        """Close the source."""
        ...


class WirePort(OpenPort, Protocol):
    """The port of a link: a serial device or an address in a network; reads and writes do not wait."""

    connecting: bool
    """Whether it is not open yet: when `fileno` is readable, call `establish`."""

    def establish(self) -> None:
        """End the connecting; raises LinkError if the port is not open then."""
        ...

    def read(self) -> bytes:
        """Return received data, maybe none; raises OSError when the port is lost."""
        ...

    def write(self, data: bytes) -> None:
        """Send data; data without room are lost; raises OSError when the port is lost."""
        ...


class DescriptorPort:
    """An open source as a port.

    Args:
        source: the source; it is closed with the port.
    """

    connecting = False

    def __init__(self, source: OpenPort) -> None:
        self._source = source

    def establish(self) -> None:
        """Do nothing: it is open."""

    def fileno(self) -> int:
        return self._source.fileno()

    def read(self) -> bytes:
        data = os.read(self._source.fileno(), READ_BYTES)
        if not data:
            raise OSError("end of file")
        return data

    def write(self, data: bytes) -> None:
        with suppress(BlockingIOError):  # no room: a request that is not answered
            os.write(self._source.fileno(), data)

    def close(self) -> None:
        self._source.close()


def open_wire(port: str, baudrate: int, *, parity: str = "N", stopbits: int = 1) -> WirePort:
    """Open a device, or begin to connect to an address; the settings are for a serial line.

    Raises:
        LinkBusyError: another link or process uses it; the message names it.
        LinkError: the device is missing, not permitted, or no serial port.
    """
    if address := network_address(port):
        return NetworkPort(address, SerialSettings(baudrate, parity, stopbits))
    return DescriptorPort(open_port(port, baudrate, parity=parity, stopbits=stopbits))


def users_of(port: str) -> list[Holder]:
    """Return the other processes that use the port of a link, as far as this user may see them."""
    address = network_address(port)
    return holders_of_address(address.place) if address else holders_of(port)


def open_port(
    path: str, baudrate: int, *, parity: str = "N", stopbits: int = 1, write_timeout_s: float = 1.0
) -> serial.Serial:
    """Open the port: raw, 8 bits, exclusive, input flushed; a read returns the available data and does not wait.

    Raises:
        LinkBusyError: another process has the port; the message names it.
        LinkError: the port is missing, not permitted, or no serial port.
    """
    from termios import error as refused

    import serial  # what needs no port needs no POSIX

    try:
        return serial.Serial(
            path,
            baudrate,
            # a pseudo-terminal has no parity: the kernel takes it out, and a second setting of it alone is an error
            parity="N" if os.path.realpath(path).startswith("/dev/pts/") else parity,
            stopbits=stopbits,
            timeout=0,
            write_timeout=write_timeout_s,
            exclusive=True,
            inter_byte_timeout=None,
        )
    except refused as error:
        raise LinkError(
            f"the port refuses {baudrate} baud, parity {parity}, {stopbits} stop bits: {error.args[-1]}.",
            where=path,
            todo="Does the port support this? The keys are link.baudrate, link.parity and link.stopbits.",
        ) from error
    except (OSError, ValueError) as error:
        raise _explained(path, baudrate, error) from error


def _explained(path: str, baudrate: int, error: OSError | ValueError) -> LinkError:
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        ports = sorted({port for pattern in _USUAL for port in glob.glob(pattern)})
        return LinkError(
            "the port does not exist.",
            where=path,
            todo=f"Ports here: {', '.join(ports) or 'none'}. Is the device plugged in? Does the testbench run?",
        )
    if number in (errno.EACCES, errno.EPERM):
        return LinkError(
            "the port may not be opened: permission denied.",
            where=path,
            todo="Add the user to the group dialout (sudo usermod -aG dialout $USER), then log in again.",
        )
    if number in (errno.EBUSY, errno.EAGAIN):
        return LinkBusyError(
            f"the port is used by {' and '.join(map(str, holders_of(path, own=True))) or 'another program'}.",
            where=path,
            todo="Stop that program: two readers would steal each other's bytes.",
        )
    # pyserial wraps termios' error in a text.
    if re.search(rf"\b({errno.ENOTTY}|{errno.EINVAL}|{errno.EISDIR})\b", str(error)):
        return LinkError(
            "this is not a serial port.",
            where=path,
            todo="Give the device of the UART, such as /dev/verdin-uart1.",
        )
    return LinkError(
        f"the port cannot be opened at {baudrate} baud: {error}.",
        where=path,
        todo="Does the port support this rate? The key is link.baudrate.",
    )
