"""QEMU's qtest socket: it answers commands, and tells of pins in between."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue


class Qtest:
    """The connection, from `open` to `close`.

    Args:
        path: of the socket.
        told: each line that is no answer, "" at the end; called in a thread of its own, and must not block.
    """

    def __init__(self, path: str, told: Callable[[str], None]) -> None:
        self._path, self._told = path, told
        self._answers: SimpleQueue[str] = SimpleQueue()
        self._asking = threading.Lock()
        self._thread: threading.Thread | None = None

    def open(self, patience_s: float) -> None:
        """Connect, to a machine that may come later; raises OSError."""
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._connect(time.monotonic() + patience_s)
        except OSError:
            self._socket.close()
            raise
        self._thread = threading.Thread(target=self._run, name="qtest", daemon=True)
        self._thread.start()

    def ask(self, command: str) -> str:
        """The answer to a command; "": the machine has ended."""
        with self._asking:
            try:
                self._socket.sendall(f"{command}\n".encode())
            except OSError:
                return ""
            answer = self._answers.get()
            if not answer:
                self._answers.put("")  # for whoever asks next
            return answer

    def close(self) -> None:
        """End; nothing is told after it. May be called again."""
        thread, self._thread = self._thread, None
        if thread is not None:
            with suppress(OSError):  # it has ended
                self._socket.shutdown(socket.SHUT_RDWR)
            thread.join()
            self._socket.close()

    def _connect(self, end: float) -> None:
        while True:
            try:
                return self._socket.connect(self._path)
            except (FileNotFoundError, ConnectionRefusedError):
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)

    def _run(self) -> None:
        try:
            with self._socket.makefile(encoding="ascii", errors="replace") as lines:
                for line in lines:
                    if line.startswith(("OK", "FAIL", "ERR")):
                        self._answers.put(line.strip())
                    else:
                        self._told(line.strip())
        except OSError:
            pass  # reset: it has ended
        self._answers.put("")
        self._told("")
