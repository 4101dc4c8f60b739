"""Notifications for a service manager (systemd's sd_notify(3)); without a service manager nothing happens."""

from __future__ import annotations

import logging
import os
import socket
import threading
from array import array
from collections.abc import Callable, Mapping

from end_effector_hal._closing import Closing
from end_effector_hal.errors import ReportedError

_FIRST_FD = 3
_log = logging.getLogger("end_effector_hal.arbiter")


class ServiceManager(Closing):
    """Notify the service manager that the program is ready, and regularly that it lives.

    Args:
        environ: with ``NOTIFY_SOCKET``, ``WATCHDOG_USEC``, ``WATCHDOG_PID``, ``LISTEN_PID``, ``LISTEN_FDS`` and
            ``LISTEN_FDNAMES`` of systemd.
    """

    def __init__(self, environ: Mapping[str, str] = os.environ) -> None:
        address = environ.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._watchdog_s = _watchdog_s(environ) if address else 0.0
        self._end = threading.Event()
        self._stored = _stored_descriptors(environ)
        self._thread: threading.Thread | None = None

    def ready(self, status: str, alive: Callable[[], object]) -> None:
        """Notify that the program serves, and start the watchdog.

        Args:
            status: a sentence, shown by ``systemctl status``.
            alive: called in a thread, three times in the time that the watchdog allows; while it raises
                ReportedError the manager is not notified, so that it ends the program and starts it again.
        """
        self._notify(f"READY=1\nSTATUS={' '.join(status.split())}")
        if self._watchdog_s:
            self._thread = threading.Thread(target=self._run, args=(alive,), name="watchdog", daemon=True)
            self._thread.start()

    def stored_descriptors(self) -> dict[str, int]:
        """Return the descriptors that the previous program stored, by name; the caller closes them."""
        stored, self._stored = self._stored, {}
        return stored

    def store(self, descriptors: Mapping[str, int]) -> None:
        """Store copies of descriptors in the manager while this program is replaced (FDSTORE); they replace older
        ones.
        """
        for name, fd in descriptors.items():
            self._notify(f"FDSTOREREMOVE=1\nFDNAME={name}")
            self._notify(f"FDSTORE=1\nFDNAME={name}", fd)

    def close(self) -> None:
        """Stop the notifications."""
        self._end.set()
        if self._thread and self._thread.ident is not None:
            self._thread.join()

    def _run(self, alive: Callable[[], object]) -> None:
        while not self._end.wait(self._watchdog_s / 3):
            try:
                alive()
            except ReportedError as error:
                _log.error("the watchdog is not notified that this program lives: %s", error)
            else:
                self._notify("WATCHDOG=1")

    def _notify(self, message: str, *descriptors: int) -> None:
        if not self._address:
            return
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array("i", descriptors))] if descriptors else []
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as manager:
                manager.settimeout(1)
                manager.connect(self._address)
                manager.sendmsg([message.encode()], rights)
        except OSError as error:
            # an error here must not disturb the tool
            _log.warning("the service manager cannot be notified: %s", error)


def _stored_descriptors(environ: Mapping[str, str]) -> dict[str, int]:
    """Return the named descriptors from 3 on, if systemd passed them to this process."""
    count, pid = environ.get("LISTEN_FDS", ""), environ.get("LISTEN_PID", "")
    if pid != str(os.getpid()) or not count.isdigit():
        return {}
    names, found = environ.get("LISTEN_FDNAMES", "").split(":"), dict[str, int]()
    for index in range(int(count)):
        fd, name = _FIRST_FD + index, names[index] if index < len(names) else ""
        try:
            os.set_inheritable(fd, False)
        except OSError:
            continue
        if not name or name in found:
            os.close(fd)
        else:
            found[name] = fd
    return found


def _watchdog_s(environ: Mapping[str, str]) -> float:
    """Return the period of the watchdog; 0: there is none for this process."""
    period, pid = environ.get("WATCHDOG_USEC", ""), environ.get("WATCHDOG_PID", "")
    mine = not pid or pid == str(os.getpid())
    return int(period) / 1e6 if mine and period.isdigit() else 0.0
