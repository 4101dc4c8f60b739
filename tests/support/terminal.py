"""A program on a terminal of its own (a pty): what a person sees and types."""

from __future__ import annotations

import fcntl
import os
import re
import select
import signal
import struct
import subprocess
import termios
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

LONG_S = 60.0
_ESCAPE = re.compile(r"\x1b(\[[0-9;?]*[A-Za-z]|[()][A-Z0-9]|[=>])|[\x01\x02\x07]")


class Terminal:
    """Starts a command with all three streams on a terminal of 40 lines and 160 columns."""

    def __init__(self, command: Sequence[str], *, env: Mapping[str, str] | None = None) -> None:
        self._own, other = os.openpty()
        fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 160, 0, 0))
        self.process = subprocess.Popen(
            ["setsid", "--ctty", "--wait", "env", "--default-signal=INT", *command],
            stdin=other,
            stdout=other,
            stderr=other,
            env={**os.environ, "TERM": "xterm", **(env or {})},
            start_new_session=True,
        )
        os.close(other)
        self.raw = ""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._own)

    @property
    def text(self) -> str:
        """What was written so far, without colours and movements of the cursor."""
        return _ESCAPE.sub("", self.raw).replace("\r\n", "\n")

    def type(self, text: str) -> None:
        """Press keys; ``\\x03`` is Ctrl-C."""
        os.write(self._own, text.encode())

    def read_until(self, pattern: str, *, after: int = 0) -> int:
        """Wait for a regular expression in :attr:`text` from ``after`` on; returns where it ends."""
        until = time.monotonic() + LONG_S
        while not (found := re.compile(pattern).search(self.text, after)):
            assert self._read(until), f"{pattern!r} was not said: {self.text}"
        return found.end()

    def end(self) -> int:
        """Read all that comes until the program ends; returns its exit code."""
        until = time.monotonic() + LONG_S
        while self._read(until):
            pass
        return self.process.wait(LONG_S)

    def _read(self, until: float) -> bool:
        ready, _, _ = select.select([self._own], [], [], max(0.0, until - time.monotonic()))
        try:
            data = os.read(self._own, 65_536) if ready else b""
        except OSError:  # the other end is closed
            data = b""
        self.raw += data.decode(errors="replace")
        return bool(data)

    def interrupt(self) -> None:
        """Ctrl-C."""
        self.type("\x03")


def on_a_terminal(command: Sequence[str], *, env: Mapping[str, str] | None = None) -> tuple[int, str]:
    """Run a command to its end; returns its exit code and what it wrote."""
    with Terminal(command, env=env) as terminal:
        code = terminal.end()
        return code, terminal.text


__all__ = ["Terminal", "on_a_terminal", "signal"]
