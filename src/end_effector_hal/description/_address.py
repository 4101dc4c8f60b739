"""Ports that are addresses in a network: ``tcp://host[:502]``, ``rtu+tcp://…``, ``socket://…``, ``rfc2217://…``."""

from __future__ import annotations

import re
from typing import NamedTuple
from zlib import crc32

MODBUS_PORT = 502
MODBUS_SCHEMES = ("tcp", "rtu+tcp")
"""Modbus TCP, and the frames of Modbus RTU over TCP, as transparent gateways transmit them."""
STREAMS = ("socket", "rfc2217")
"""The bytes as they come, and a serial port that is set over the network (RFC 2217)."""
_HOST = r"\[[0-9a-fA-F:.]+(?:%\w+)?\]|[A-Za-z0-9](?:[A-Za-z0-9._-]{0,251}[A-Za-z0-9])?"
_FORM = re.compile(rf"(?P<scheme>[a-z0-9+]+)://(?P<host>{_HOST})(?::(?P<port>\d{{1,5}}))?")
_ANY = re.compile(
    rf"(?:[A-Za-z0-9+.-]*:/+)?(?P<host>{_HOST})(?::(?P<port>\d{{1,5}}))?(?:[/?#].*)?", re.IGNORECASE
)
_LOOKS = re.compile(r"[^/]*:.*|(\d+\.){3}\d+.*|[^/]+\.(local|lan|home|internal)", re.IGNORECASE)
"""Matches a network address and no path: a URL, a host with a port number, an IP address, a host name."""
_FIELDBUSES = {
    "EtherCAT": r"ethercat|ecat",
    "PROFINET": r"profinet|pnio",
    "EtherNet/IP": r"ethernet-?ip|enip|eip",
    "CAN": r"(socket|v|sl)?can(open)?\d*",
    "OPC UA": r"opc|opc-?ua|opc\.tcp",
}


class NetworkAddress(NamedTuple):
    """An address in a network; ``host``: a name or an IP address, without brackets."""

    scheme: str
    host: str
    port: int

    @property
    def place(self) -> str:
        """Host and port, which only one link may use: ``192.168.1.20:502``."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host.lower()}:{self.port}"

    @property
    def has_line(self) -> bool:
        """Whether the settings of a serial line (baud rate, parity, stop bits) count at the far end."""
        return self.scheme == "rfc2217"

    def __str__(self) -> str:
        return f"{self.scheme}://{self.place}"


def network_address(port: str) -> NetworkAddress | None:
    """Return the address that a `port` gives; None: it is a device, or no valid address."""
    found = _FORM.fullmatch(port)
    if found is None or found["scheme"] not in (*MODBUS_SCHEMES, *STREAMS):
        return None
    usual = MODBUS_PORT if found["scheme"] == "tcp" else 0
    number = int(found["port"]) if found["port"] else usual
    host = found["host"].strip("[]")
    return NetworkAddress(found["scheme"], host, number) if 0 < number < 65536 else None


def has_line(port: str) -> bool:
    """Return whether the settings of a serial line count: at a device, or at an address whose far end takes them."""
    address = network_address(port)
    return address is None or address.has_line


def looks_like_address(port: str) -> bool:
    """Return whether a `port` looks like an address in a network, valid or not."""
    return _LOOKS.fullmatch(port) is not None


def refused_fieldbus(text: str) -> str:
    """Return a hint if a port, a codec or a key names a fieldbus that is not supported; empty: it names none."""
    word = text.lower().removeprefix("/dev/").partition(":")[0].replace("_", "-")
    found = next((name for name, form in _FIELDBUSES.items() if re.fullmatch(form, word)), "")
    return f"{found} is not supported: use a gateway or an I/O station with Modbus TCP" if found else ""


def right_form(port: str, *, modbus: bool) -> str:
    """Return the address that somebody may have meant, for a message."""
    found = _ANY.fullmatch(port)
    host, given = (found["host"], found["port"]) if found else ("HOST", None)
    given = given if given and 0 < int(given) < 65536 else None
    if not modbus:
        return f"socket://{host}:{given or 'PORT'}"
    gateway = f"rtu+tcp://{host}:{given or 'PORT'} for a gateway that transmits RTU frames"
    return f"tcp://{host}:{given or MODBUS_PORT} for Modbus TCP, or {gateway}"


def loopback(address: NetworkAddress, place: str) -> NetworkAddress:
    """Return an address of this machine for a simulated device, a different one for each ``place`` (a path)."""
    number = crc32(place.encode())
    host = f"127.{1 + number % 250}.{number // 250 % 250}.{1 + number // 62_500 % 250}"
    scheme = "socket" if address.scheme == "rfc2217" else address.scheme
    return NetworkAddress(scheme, host, 20_000 + number // 15_625_000)
