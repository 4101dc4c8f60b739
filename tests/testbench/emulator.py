"""QEMU, as far as its qtest socket can tell."""

from __future__ import annotations

import socket
import threading
from pathlib import Path


class Emulator:
    """Has one GPIO controller; tells of its pins once that was asked for."""

    def __init__(self, path: Path, controller: str = "/machine/soc/gpio1") -> None:
        self._controller = controller
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen(1)
        self._asked = threading.Event()
        self.connection: socket.socket | None = None
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def drive(self, pin: int, level: bool) -> None:
        """The machine drives a pin; sent in two parts, as a stream may."""
        assert self._asked.wait(20)
        assert self.connection is not None
        for part in (b"IRQ ra" if level else b"IRQ lo", b"ise %d\n" % pin if level else b"wer %d\n" % pin):
            self.connection.sendall(part)

    def off(self) -> None:
        """It ends."""
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join()
        if self.connection is not None:
            self.connection.close()

    def _serve(self) -> None:
        try:
            self.connection, _ = self._listener.accept()
        except OSError:
            return
        with self.connection.makefile() as lines:
            asked = lines.readline()
        known = asked == f"irq_intercept_out {self._controller}\n"
        self.connection.sendall(b"OK\n" if known else b"FAIL Unknown device\n")
        self._asked.set()
