"""The relays of the line arbiter: Unix sockets over which programs receive the readings of its bus or inputs."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.errors import LinkError

from .rpc import Client, ClientLimits

RELAYED = ClientLimits(clients=8, backlog=0)
"""Limits of a relay's readers. No backlog: a delayed frame is useless, and the relay does not wait for slow readers."""
CONNECT_S = 1.0


def relay_path(arbiter: Path, what: str = "bus") -> Path:
    """Return the path of the relay for the bus or the inputs of the line arbiter at this socket."""
    return arbiter.with_name(f"{arbiter.name}.{what}")


def connect_relay(path: Path, what: str = "is the master of this bus, does not relay it") -> Client:
    """Connect to a relay for reading; raises LinkError.

    Args:
        path: the socket of the relay.
        what: completes the error message "the line arbiter, which …".
    """
    client = Client(path, None)
    try:
        client.connect(CONNECT_S)
    except OSError as error:
        raise LinkError(
            f"the line arbiter, which {what}: {error.strerror or error}.",
            where=str(path),
            todo="Start it: eehal arbiter DESCRIPTION, or systemctl start eehal-arbiter@TOOL.",
        ) from error
    return client
