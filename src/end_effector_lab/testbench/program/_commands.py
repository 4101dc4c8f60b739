"""Commands of a running testbench on standard input, and its messages on standard output."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator

from end_effector_hal.cli import json_text
from end_effector_hal.errors import UsageError


class Voice:
    """Prints one line at a time without buffering; if nobody reads any more, it continues without output.

    Args:
        as_json: print every line as a JSON object.
    """

    def __init__(self, *, as_json: bool = False) -> None:
        self._as_json = as_json

    def say(self, text: str, **fields: object) -> None:
        """Print ``text`` for people, or ``fields`` as JSON for programs."""
        line = json_text(fields) if self._as_json else text
        self._write(line, 1)

    def refuse(self, text: str) -> None:
        """Print a refusal to standard error (with JSON: ``{"refused": …}`` to standard output)."""
        if self._as_json:
            self._write(json_text({"refused": text}), 1)
        else:
            self._write(f"refused: {text}", 2)

    def _write(self, line: str, fd: int) -> None:
        stream = sys.stdout if fd == 1 else sys.stderr
        if stream is None:  # it was closed when the program was started
            return
        try:
            stream.write(line + "\n")
            stream.flush()
        except OSError:  # the buffer keeps its content: let it go where it does no harm
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, fd)
            os.close(silence)


class Commands:
    """Executes commands, one per line: ``scenario TEXT`` and ``quit``.

    Args:
        voice: prints ``scenario: TEXT``, or a refusal.
        choose: called with the text of a scenario.
        end: ends the program.
    """

    def __init__(self, voice: Voice, choose: Callable[[str], None], end: Callable[[], None]) -> None:
        self._voice, self._choose, self._end = voice, choose, end

    def obey(self, line: str) -> None:
        """Execute one command; an empty one does nothing."""
        word, _, rest = line.partition(" ")
        scenario = rest.strip()
        try:
            if word == "scenario" and scenario:
                self._choose(scenario)
                self._voice.say(f"scenario: {scenario}", scenario=scenario)
            elif line == "quit":
                self._end()
            elif line:
                raise UsageError(f"there is no command {line!r}.", todo="There are: scenario TEXT, quit.")
        except UsageError as error:
            self._voice.refuse(str(error))


def lines_of(fd: int) -> Iterator[str]:
    """Yield lines until the end of input; the last may lack its newline."""
    data, rest = b"-", b""
    while data:
        try:
            data = os.read(fd, 4096)
        except OSError:  # a terminal in which another program is in front
            return
        *lines, rest = (rest + data).split(b"\n")
        for line in lines if data else [rest]:
            yield line.decode(errors="replace").strip()
