"""Tells the line owner what the sensors prove; never waits for it."""

from __future__ import annotations

import logging
import socket
from collections.abc import Mapping
from pathlib import Path

from end_effector_hal.wires.owner._protocol import write_message

_log = logging.getLogger("end_effector_hal.owner")


class Teller:
    """A connection that only sends, and is made anew whenever it can be. Not thread-safe.

    What cannot be sent at once is not sent later: it would be old by then.

    Args:
        socket_path: of the owner; it need not be there yet.
    """

    def __init__(self, socket_path: str | Path) -> None:
        self._path = str(socket_path)
        self._socket: socket.socket | None = None
        self._rest = b""

    def tell(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Send; whether it was sent as a whole.

        Args:
            predicates: by name; see `Need`.
            at_us: when the sensors proved it, monotonic clock.
        """
        try:
            sock = self._connected()
            # A message that was cut is ended first, so that the next one can be read.
            data = self._rest + write_message({"op": "tell", "predicates": dict(predicates), "at_us": at_us})
            sent = sock.send(data)
            self._rest = data[sent:]
        except BlockingIOError:
            return False
        except OSError as error:
            if self._socket is not None:
                _log.warning("the line owner cannot be told what the sensors say: %s", error)
            self.close()
            return False
        return not self._rest

    def close(self) -> None:
        """Say nothing any more."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._rest = b""

    def _connected(self) -> socket.socket:
        if self._socket is None:
            sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            sock.setblocking(False)
            try:
                sock.connect(self._path)
            except OSError:
                sock.close()
                raise
            self._socket = sock
        return self._socket
