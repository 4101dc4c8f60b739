"""What a service manager is told (the protocol of systemd's sd_notify(3)); without one, nothing happens."""

from __future__ import annotations

import logging
import os
import socket
import threading
from collections.abc import Callable, Mapping

from end_effector_hal.errors import EndEffectorError

_log = logging.getLogger("end_effector_hal.owner")


class ServiceManager:
    """Tells it that the program is ready, and again and again that it lives.

    Args:
        environ: ``NOTIFY_SOCKET``, ``WATCHDOG_USEC`` and ``WATCHDOG_PID`` are taken from it.
    """

    def __init__(self, environ: Mapping[str, str] = os.environ) -> None:
        address = environ.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._watchdog_s = _watchdog_s(environ) if address else 0.0
        self._end = threading.Event()
        self._thread: threading.Thread | None = None

    def ready(self, status: str, alive: Callable[[], object]) -> None:
        """The program serves from now on.

        Args:
            status: a sentence, shown by ``systemctl status``.
            alive: asked, in a thread, three times in the time that the watchdog allows; while it raises
                EndEffectorError nothing is told, so that the manager ends the program and starts it again.
        """
        self._tell(f"READY=1\nSTATUS={' '.join(status.split())}")
        if self._watchdog_s:
            self._thread = threading.Thread(target=self._run, args=(alive,), name="watchdog", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Tell nothing any more."""
        self._end.set()
        if self._thread:
            self._thread.join()

    def __enter__(self) -> ServiceManager:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self, alive: Callable[[], object]) -> None:
        while not self._end.wait(self._watchdog_s / 3):
            try:
                alive()
            except EndEffectorError as error:
                _log.error("the watchdog is not told that this program lives: %s", error)
            else:
                self._tell("WATCHDOG=1")

    def _tell(self, message: str) -> None:
        if not self._address:
            return
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as manager:
                manager.settimeout(1)
                manager.sendto(message.encode(), self._address)
        except OSError as error:
            # it is the manager's loss, not the tool's
            _log.warning("the service manager cannot be told: %s", error)


def _watchdog_s(environ: Mapping[str, str]) -> float:
    """How often a sign of life is wanted; 0: never, or not of this process."""
    period, pid = environ.get("WATCHDOG_USEC", ""), environ.get("WATCHDOG_PID", "")
    mine = not pid or pid == str(os.getpid())
    return int(period) / 1e6 if mine and period.isdigit() else 0.0
