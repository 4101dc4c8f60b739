"""Rules for the port of a link: a serial device, or an address in a network that fits its frames."""

from __future__ import annotations

from collections.abc import Iterator
from posixpath import normpath

from end_effector_hal.description._address import (
    MODBUS_SCHEMES,
    STREAMS,
    looks_like_address,
    network_address,
    refused_fieldbus,
    right_form,
)
from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._shape import Facts


def port_faults(facts: Facts, link: Keys) -> Iterator[Fault]:
    """Yield the faults of a link's port, and of keys that such a port does not have."""
    port = facts.get(*link, "port")
    if port is None:
        return
    place, modbus = facts.places.value(*link, "port"), facts.says(*link, "frame", "modbus")
    if hint := refused_fieldbus(port):
        yield Fault.at(place, "EE-211", "'port' is no address that this link can use", expected="", hint=hint)
        return
    if not looks_like_address(port):
        return
    # a codec may be either; whether it fits is checked when it is known
    schemes = (
        MODBUS_SCHEMES if modbus else STREAMS if facts.says(*link, "frame") else (*MODBUS_SCHEMES, *STREAMS)
    )
    address = network_address(port)
    if address is None or address.scheme not in schemes:
        what = "'port' is no address that this link can use"
        guess = modbus or (address is None and schemes != STREAMS)
        yield Fault.at(place, "EE-211", what, expected=right_form(port, modbus=guess))
        return
    if not address.has_line:
        for key in ("baudrate", "parity", "stopbits"):
            if facts.says(*link, key):
                what, hint = f"{key!r} is for a serial line", "the far end has its own settings"
                yield facts.key_fault((*link, key), "EE-228", what, "no such key", hint=hint)


def place_of(port: str) -> str:
    """Return the place that only one link may use: the path of a device, or host and port of an address."""
    address = network_address(port)
    return address.place if address else normpath(port)


def unit_faults(facts: Facts, link: Keys | None, path: Keys) -> Iterator[Fault]:
    """Yield a fault if the unit of a register is the broadcast of its line: no device answers that."""
    if facts.get(*path, "unit") != 0 or link is None or (port := facts.get(*link, "port")) is None:
        return
    address = network_address(port)
    if address is None or address.scheme != "tcp":
        what = "unit 0 is the broadcast of a serial line"
        yield facts.fault((*path, "unit"), "EE-208", what, "1 to 255; 0 is possible with tcp://")
