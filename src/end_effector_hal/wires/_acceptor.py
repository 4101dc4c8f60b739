"""Accepts clients at a socket, also where this process has no file for them."""

from __future__ import annotations

import errno
import logging
import os
import socket
import time
from contextlib import suppress
from pathlib import Path

_log = logging.getLogger("end_effector_hal.wires")
REST_S = 0.01


class Acceptor:
    """A listening socket. One who waits there is readable for ever: where nobody can be accepted, that would spin.

    So a file is kept in reserve: it is closed for one whom there is no other file for, who is sent away with it.

    Args:
        listener: it does not block; `close` closes it.
        what: it is, for the log.
        path: of the socket, which `close` removes unless somebody else has taken its place; None: it stays.
    """

    def __init__(self, listener: socket.socket, what: str, path: Path | None = None) -> None:
        self.listener, self._what = listener, what
        self._path, self._inode = path, path.stat().st_ino if path else 0
        self._told = False
        self._spare = -1
        self._reserve()

    def accept(self) -> socket.socket | None:
        """Who has come; None: nobody, or one who was sent away."""
        try:
            sock, _ = self.listener.accept()
        except BlockingIOError:
            return None
        except OSError as error:
            if error.errno != errno.ECONNABORTED:
                self._send_away(error)
            return None
        self._told = False
        return sock

    def close(self) -> None:
        """Nobody can come any more."""
        self._release()
        self.listener.close()
        with suppress(OSError):  # not that of one who came after us
            if self._path is not None and self._path.stat().st_ino == self._inode:
                self._path.unlink()

    def _send_away(self, error: OSError) -> None:
        if not self._told:
            _log.warning("%s: a client is sent away: %s", self._what, error.strerror or error)
        self._told = True
        self._release()
        try:
            self.listener.accept()[0].close()
        except BlockingIOError:
            pass
        except OSError:  # another thread was quicker, or this machine lacks more than files
            time.sleep(REST_S)
        self._reserve()

    def _release(self) -> None:
        spare, self._spare = self._spare, -1
        if spare >= 0:
            os.close(spare)

    def _reserve(self) -> None:
        with suppress(OSError):
            self._spare = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
