"""Lines of an emulated GPIO controller: QEMU reports changes of its output pins (its qtest interface)."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from queue import SimpleQueue

from end_effector_hal.errors import WireError
from end_effector_lab.testbench.inputs import OnEdge

COUNTER, HERTZ, BITS = 0x30370054, 32768, 32
"""Low word of the real-time counter of an i.MX 8M Plus (SNVS); with ``-rtc clock=vm`` it counts the machine's time."""
LEAST_S, MOST_S = 0.001, 0.1


class GuestClock:
    """Reads a counter of the machine.

    A machine that counts instructions (``-icount``) has its own time: it stops while the host has no time for it, and
    is never ahead of the host's while it idles. Waiting for it therefore needs polling.

    Args:
        ask: sends a qtest command to QEMU; returns "" if QEMU has ended, whose clock then stops.
    """

    def __init__(self, ask: Callable[[str], str]) -> None:
        self._ask = ask
        self._lock = threading.Lock()
        self._last: int | None = None
        self._ticks = 0

    def now_us(self) -> int:
        """Return the time since the first call, µs."""
        with self._lock:
            count = self._count()
            if count is not None and self._last is not None:
                self._ticks += (count - self._last) % (1 << BITS)
            self._last = self._last if count is None else count
            return self._ticks * 1_000_000 // HERTZ

    def wait(self, stop: threading.Event, until: int) -> bool:
        while (left := until - self.now_us()) > 0:
            if stop.wait(min(max(left / 1e6, LEAST_S), MOST_S)):
                return True
        return stop.is_set()

    def _count(self) -> int | None:
        match self._ask(f"readl {COUNTER:#x}").split():
            case ["OK", number]:
                return int(number, 16)
        return None


class Qtest:
    """The connection to QEMU, from `open` to `close`.

    Args:
        path: path of the socket.
        told: receives each line that is not an answer, "" at the end; called in a separate thread, and must not block.
    """

    def __init__(self, path: str, told: Callable[[str], None]) -> None:
        self._path, self._told = path, told
        self._answers: SimpleQueue[str] = SimpleQueue()
        self._asking = threading.Lock()
        self._thread: threading.Thread | None = None

    def open(self, patience_s: float) -> None:
        """Connect; wait for a machine that starts later; raises OSError."""
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._connect(time.monotonic() + patience_s)
        except OSError:
            self._socket.close()
            raise
        self._thread = threading.Thread(target=self._run, name="qtest", daemon=True)
        self._thread.start()

    def ask(self, command: str) -> str:
        """Return the answer to a command; "" if the machine has ended."""
        with self._asking:
            try:
                self._socket.sendall(f"{command}\n".encode())
            except OSError:
                return ""
            answer = self._answers.get()
            if not answer:
                self._answers.put("")  # for the next caller
            return answer

    def close(self) -> None:
        """Close the connection; no line is reported afterwards. May be called again."""
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


CONTROLLER = "/machine/soc/gpio1"
"""Path of the lines' controller in QEMU's imx8mp-evk; QMP's qom-list finds others."""
PATIENCE_S = 60.0


class QemuInputs:
    """Pins of one controller of a machine that was started with ``-qtest unix:SOCKET,server=on,wait=off -S``.

    Start this first, then let the machine run; at power-up nothing drives a pin. The machine does not wait for this
    process.

    Args:
        path: the socket.
        offsets: line -> pin of the controller.
        patience_s: how long to wait for the socket: the machine may need the host's end of its UART to start.

    Attributes:
        clock: the machine's clock; edges get its time, a little after they happened.
    """

    def __init__(self, path: str, offsets: Mapping[str, int], *, patience_s: float = PATIENCE_S) -> None:
        self._path, self._patience_s = path, patience_s
        self._lines = {offset: line for line, offset in offsets.items()}
        self._told: SimpleQueue[str | None] = SimpleQueue()
        self._qtest = Qtest(path, self._told.put)
        self.clock = GuestClock(self._qtest.ask)
        self._thread: threading.Thread | None = None

    @property
    def text(self) -> str:
        return f"qemu:{self._path}"

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        try:
            self._qtest.open(self._patience_s)
            answer = self._qtest.ask(f"irq_intercept_out {CONTROLLER}")
            if not answer:
                raise ConnectionResetError(0, "it has ended")
        except OSError as error:
            self._qtest.close()
            raise WireError(
                f"the emulated machine does not answer: {error.strerror or error}.",
                where=self._path,
                todo="Start QEMU with -qtest unix:SOCKET,server=on,wait=off -S.",
            ) from error
        if not answer.startswith("OK"):
            self._qtest.close()
            raise WireError(
                f"the emulated machine has no GPIO controller {CONTROLLER}: {answer}.",
                where=self._path,
                todo="QMP's qom-list names its devices.",
            )
        self._thread = threading.Thread(target=self._run, args=(on_edge,), name="lines", daemon=True)
        self._thread.start()
        return dict.fromkeys(self._lines.values(), False)

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            self._told.put(None)
            thread.join()
            self._qtest.close()

    def _run(self, on_edge: OnEdge) -> None:
        levels = dict.fromkeys(self._lines, False)
        while (line := self._told.get()) is not None:
            match line.split():
                case ["IRQ", ("raise" | "lower") as edge, number] if number.isdigit():
                    offset, level = int(number), edge == "raise"
                    if levels.get(offset, level) != level:
                        levels[offset] = level
                        on_edge(self._lines[offset], level, self.clock.now_us())
                case []:
                    return self._off(levels, on_edge)
        return None

    def _off(self, levels: Mapping[int, bool], on_edge: OnEdge) -> None:
        """Report all lines as off after the machine has ended, since nothing drives its pins."""
        for offset, level in levels.items():
            if level:
                on_edge(self._lines[offset], False, self.clock.now_us())
