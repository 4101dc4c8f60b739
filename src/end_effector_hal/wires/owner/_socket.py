"""The owner's Unix socket."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from end_effector_hal.errors import WireError


def listen(path: Path) -> socket.socket:
    """Bound under another name first, so that whoever finds the socket can connect."""
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        fresh.unlink(missing_ok=True)
        listener.bind(str(fresh))
        fresh.chmod(0o660)
        listener.listen(16)
        listener.setblocking(False)
        fresh.replace(path)
    except OSError as error:
        listener.close()
        raise no_socket(path, error) from error
    return listener


def no_socket(path: Path, error: OSError) -> WireError:
    return WireError(
        f"the line owner's socket cannot be made: {error.strerror or error}.",
        where=str(path),
        todo="Give a path of less than 90 letters in a directory that can be written.",
    )
