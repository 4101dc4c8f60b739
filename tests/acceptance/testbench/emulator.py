"""QEMU, as far as its qtest socket can tell."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from pathlib import Path

from tests.support.patience import PATIENCE_S


class Emulator:
    """Has one GPIO controller; tells of its pins once that was asked for. ``ticks``: of its counter."""

    def __init__(self, path: Path, controller: str = "/machine/soc/gpio1") -> None:
        self._controller = controller
        self.ticks = 0
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen(1)
        self._asked = threading.Event()
        self.connection: socket.socket | None = None
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def drive(self, pin: int, level: bool) -> None:
        """The machine drives a pin."""
        assert self._asked.wait(PATIENCE_S)
        assert self.connection is not None
        self.connection.sendall(b"IRQ %s %d\n" % (b"raise" if level else b"lower", pin))

    def off(self) -> None:
        """It ends."""
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        if self.connection is not None:
            with suppress(OSError):  # the other end has gone
                self.connection.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        if self.connection is not None:
            self.connection.close()

    def _serve(self) -> None:
        try:
            self.connection, _ = self._listener.accept()
        except OSError:
            return
        with self.connection.makefile() as lines, suppress(OSError):
            for line in lines:
                self.connection.sendall(self._answer(line.split()))
                self._asked.set()

    def _answer(self, words: list[str]) -> bytes:
        match words:
            case ["irq_intercept_out", self._controller]:
                return b"OK\n"
            case ["readl", "0x30370054"]:
                return b"OK 0x%016x\n" % (self.ticks % 2**32)
        return b"FAIL Unknown device\n"
