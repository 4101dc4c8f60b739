"""A connection that is given up delivers nothing any more; an address belongs to one user, however long its name."""

from __future__ import annotations

import select
import socket

import pytest

from end_effector_hal.errors import LinkBusyError
from end_effector_hal.wires._claim import AddressClaim
from end_effector_hal.wires.link import open_wire


def test_a_closed_connection_sends_nothing_any_more() -> None:
    """Or an activation that was given up would arrive after the release of the next connection."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = open_wire(f"rtu+tcp://127.0.0.1:{server.getsockname()[1]}", 9600)
        select.select([port.fileno()], [], [], 60)
        port.establish()
        far, _ = server.accept()
        port.write(b"x")
        assert far.recv(9) == b"x"
        port.close()
        with far, pytest.raises(ConnectionResetError):
            far.recv(9)


def test_a_long_name_is_claimed_once() -> None:
    place = f"{'a' * 200}.example:502"
    claim = AddressClaim(place)
    with pytest.raises(LinkBusyError):
        AddressClaim(place)
    claim.release()
    AddressClaim(place).release()
