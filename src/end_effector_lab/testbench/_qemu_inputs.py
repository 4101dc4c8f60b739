"""Lines of an emulated GPIO controller: QEMU tells of every change of its output pins (its qtest interface)."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from queue import SimpleQueue

from end_effector_hal.errors import WireError

from ._guest_clock import GuestClock
from ._inputs import OnEdge
from ._qtest import Qtest

CONTROLLER = "/machine/soc/gpio1"
"""That of the lines in QEMU's imx8mp-evk; others are found with QMP's qom-list."""
PATIENCE_S = 60.0


class QemuInputs:
    """Pins of one controller of a machine that was started with ``-qtest unix:SOCKET,server=on,wait=off -S``.

    The machine is to run after this was started; at power-up nothing drives a pin. It does not wait for us.

    Args:
        path: the socket.
        offsets: line -> pin of the controller.
        controller: its path in QEMU's object tree.
        patience_s: how long to wait for the socket: the machine may need our end of its UART to start.

    Attributes:
        clock: the machine's: edges are stamped with it, a little after they happened.
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
            answer = self._qtest.ask(f"irq_intercept_out {self._controller}")
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
                f"the emulated machine has no GPIO controller {self._controller}: {answer}.",
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
        """The machine has ended: nothing drives its pins any more."""
        for offset, level in levels.items():
            if level:
                on_edge(self._lines[offset], False, self.clock.now_us())
