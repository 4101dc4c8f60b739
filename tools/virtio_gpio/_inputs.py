"""The lines of a virtual machine, whose GPIO chip is the testbench."""

from __future__ import annotations

import logging
import os
import select
import socket
import threading
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import WireError
from end_effector_hal.owned import owned_folder
from end_effector_hal.wires import now_us
from end_effector_lab.testbench.inputs import OnEdge

from ._front_end import FrontEnd
from ._pins import Pins

_log = logging.getLogger("end_effector_lab.testbench")


class VirtioGpioInputs:
    """Edges of the lines that a guest drives; the guest waits until each edge has been processed.

    A guest gets the chip with ``virtio_uml.device=SOCKET:41`` (User-Mode-Linux) or QEMU's ``vhost-user-gpio-pci``. One
    guest at a time; when it disconnects, the lines are no longer outputs, and the next may connect.

    Args:
        path: the Unix socket to create.
        names: the lines.
    """

    def __init__(self, path: str | Path, names: Iterable[str]) -> None:
        self._path, self._names = Path(path), tuple(names)
        self._thread: threading.Thread | None = None

    @property
    def text(self) -> str:
        return f"virtio-gpio:{self._path}"

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        self._pins = Pins(self._names, lambda name, level: on_edge(name, level, now_us()))
        self._listener = socket.socket(socket.AF_UNIX)
        try:
            owned_folder(self._path.parent)
            if self._path.is_socket():
                self._path.unlink()
            self._listener.bind(str(self._path))
        except OSError as error:
            self._listener.close()
            raise WireError(
                f"the socket of the GPIO chip cannot be made: {error.strerror or error}.",
                where=str(self._path),
                todo="Give a short path in a directory that can be written.",
            ) from error
        self._listener.listen(1)
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, name="lines", daemon=True)
        self._thread.start()
        return self._pins.levels

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.write(self._wake, b"x")
        thread.join()
        self._listener.close()
        with suppress(OSError):
            self._path.unlink()
        os.close(self._wake)
        os.close(self._wake_read)

    def _run(self) -> None:
        while self._until(self._listener.fileno()):
            connection, _ = self._listener.accept()
            guest = FrontEnd(connection, self._pins)
            try:
                self._serve(guest)
            except WireError as error:
                _log.info("%s: %s", self.text, error)
                self._pins.power_off()
            finally:
                guest.close()

    def _serve(self, guest: FrontEnd) -> None:
        """Serve until closed; raises WireError when the guest disconnects."""
        while True:
            files = guest.files()
            ready, _, _ = select.select([*files, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            files[ready[0]]()  # only one: it may change what there is to wait for

    def _until(self, fd: int) -> bool:
        """Wait until a file is readable; return False if closed."""
        return self._wake_read not in select.select([fd, self._wake_read], [], [])[0]
