"""Lines of an emulated GPIO controller: QEMU tells of every change of its output pins (its qtest interface)."""

from __future__ import annotations

import os
import select
import socket
import threading
import time
from collections.abc import Mapping

from end_effector_hal.errors import WireError
from end_effector_hal.wires import now_us

from ._inputs import OnEdge

CONTROLLER = "/machine/soc/gpio1"
"""That of the lines in QEMU's imx8mp-evk; others are found with QMP's qom-list."""
PATIENCE_S = 20.0


class QemuInputs:
    """Pins of one controller of a machine that was started with ``-qtest unix:SOCKET,server=on,wait=off -S``.

    The machine is to run after this was started; at power-up nothing drives a pin. It does not wait for us.

    Args:
        path: the socket.
        offsets: line -> pin of the controller.
        controller: its path in QEMU's object tree.
        patience_s: how long to wait for the socket: the machine may need our end of its UART to start.
    """

    def __init__(
        self,
        path: str,
        offsets: Mapping[str, int],
        controller: str = CONTROLLER,
        *,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._path, self._controller, self._patience_s = path, controller, patience_s
        self._lines = {offset: line for line, offset in offsets.items()}
        self._thread: threading.Thread | None = None
        self._rest = b""

    @property
    def text(self) -> str:
        return f"qemu:{self._path}"

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._connect()
            self._socket.sendall(f"irq_intercept_out {self._controller}\n".encode())
            answer = self._answer()
        except OSError as error:
            self._socket.close()
            raise WireError(
                f"the emulated machine does not answer: {error.strerror or error}.",
                where=self._path,
                todo="Start QEMU with -qtest unix:SOCKET,server=on,wait=off -S.",
            ) from error
        if not answer.startswith("OK"):
            self._socket.close()
            raise WireError(
                f"the emulated machine has no GPIO controller {self._controller}: {answer}.",
                where=self._path,
                todo="QMP's qom-list names its devices.",
            )
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, args=(on_edge,), name="lines", daemon=True)
        self._thread.start()
        return dict.fromkeys(self._lines.values(), False)

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is None:
            return
        os.write(self._wake, b"x")
        thread.join()
        self._socket.close()
        os.close(self._wake)
        os.close(self._wake_read)

    def _connect(self) -> None:
        end = time.monotonic() + self._patience_s
        while True:
            try:
                return self._socket.connect(self._path)
            except (FileNotFoundError, ConnectionRefusedError):
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)

    def _answer(self) -> str:
        while b"\n" not in self._rest:
            self._receive()
        line, _, self._rest = self._rest.partition(b"\n")
        return line.decode(errors="replace").strip()

    def _receive(self) -> None:
        data = self._socket.recv(4096)
        if not data:
            raise ConnectionResetError("it has ended")
        self._rest += data

    def _run(self, on_edge: OnEdge) -> None:
        levels = dict.fromkeys(self._lines, False)
        while self._wake_read not in select.select([self._socket.fileno(), self._wake_read], [], [])[0]:
            at = now_us()
            try:
                self._receive()
            except OSError:
                return self._off(levels, on_edge)
            while b"\n" in self._rest:
                match self._answer().split():
                    case ["IRQ", ("raise" | "lower") as edge, number] if number.isdigit():
                        offset, level = int(number), edge == "raise"
                        if levels.get(offset, level) != level:
                            levels[offset] = level
                            on_edge(self._lines[offset], level, at)
        return None

    def _off(self, levels: Mapping[int, bool], on_edge: OnEdge) -> None:
        """The machine has ended: nothing drives its pins any more."""
        for offset, level in levels.items():
            if level:
                on_edge(self._lines[offset], False, now_us())
