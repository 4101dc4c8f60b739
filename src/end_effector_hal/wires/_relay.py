"""What the line arbiter reads is passed on to the programs that read the sensors, over Unix sockets."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.errors import LinkError

from .rpc import Client, ClientLimits

RELAYED = ClientLimits(clients=8, backlog=0)
"""No backlog: a frame that waits is of no use, and nobody waits for a slow reader."""
CONNECT_S = 1.0


def relay_path(arbiter: Path, what: str = "bus") -> Path:
    """Where the line arbiter that serves this socket passes on what its bus, or its inputs, bring."""
    return arbiter.with_name(f"{arbiter.name}.{what}")


def connect_relay(path: Path, what: str = "masters this bus, does not hand it on") -> Client:
    """A connection to read from; raises LinkError.

    Args:
        path: of the relay.
        what: the line arbiter does and does not, for the sentence.
    """
    client = Client(path, None)
    try:
        client.connect(CONNECT_S)
    except OSError as error:
        raise LinkError(
            f"the line arbiter, which {what}: {error.strerror or error}.",
            where=str(path),
            todo="Start it: eehal arbiter DESCRIPTION, or systemctl start eehal-arbiter.",
        ) from error
    return client
