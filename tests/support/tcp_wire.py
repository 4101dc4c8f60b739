"""A network between a program and a server: it can lose, delay and change what passes, and cut connections."""

from __future__ import annotations

import select
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Self

from tests.support.places import ROOT

STEP_S = 0.02


class TcpWire:
    """Passes bytes between those who connect to `port` and a server.

    Attributes:
        deaf: nothing passes, and nothing is closed.
        delay_s: how late answers are.
        change: what becomes of the bytes of an answer.
        connections: how many were accepted.
    """

    def __init__(self, server: int, port: int = 0) -> None:
        self._server, self.deaf, self.delay_s, self.connections = server, False, 0.0, 0
        self.change: Callable[[bytes], bytes] = lambda answer: answer
        self._listener = socket.create_server(("127.0.0.1", port))
        self.port: int = self._listener.getsockname()[1]
        self._pairs: list[tuple[socket.socket, socket.socket]] = []
        self._ended, self._lock = threading.Event(), threading.Lock()
        self._thread = threading.Thread(target=self._pass, daemon=True)
        self._thread.start()

    def reset(self) -> None:
        """Reset all connections, as a device does that loses its power and comes back."""
        with self._lock:
            pairs, self._pairs = self._pairs, []
            for near, far in pairs:
                near.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                near.close()
                far.close()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._listener.close()
        self.reset()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _pass(self) -> None:
        while not self._ended.is_set():
            with self._lock:
                ends = dict(self._pairs) | {far: near for near, far in self._pairs}
            try:
                ready = select.select([self._listener, *ends], [], [], STEP_S)[0]
            except (OSError, ValueError):  # reset meanwhile
                continue
            for end in ready:
                if end is self._listener:
                    self._accept()
                else:
                    self._forward(end, ends[end])

    def _accept(self) -> None:
        near, _ = self._listener.accept()
        self.connections += 1
        with self._lock:
            self._pairs.append((near, socket.create_connection(("127.0.0.1", self._server))))

    def _forward(self, end: socket.socket, other: socket.socket) -> None:
        try:
            data = end.recv(4096)
            if self.deaf:
                return
            if answers := any(far is end for _, far in self._pairs):
                time.sleep(self.delay_s)
                data = self.change(data)
            if data:
                other.sendall(data)
            elif not answers:
                self.reset()
        except OSError:
            pass


class Station:
    """`tests.support.modbus_server` in a process of its own."""

    def __init__(self, frames: str, *units: int) -> None:
        words = [sys.executable, "-m", "tests.support.modbus_server", frames, *map(str, units)]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=ROOT)
        assert self._process.stdout is not None
        self.port = int(self._process.stdout.readline())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()
