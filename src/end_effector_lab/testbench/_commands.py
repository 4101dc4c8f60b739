"""What can be told to a running testbench, on its standard input."""

from __future__ import annotations

import os
from collections.abc import Callable

from end_effector_hal.errors import UsageError

from ._voice import Voice


class Commands:
    """Lines of text: ``scenario TEXT`` and ``quit``.

    Args:
        voice: answers ``scenario: TEXT``, or refuses.
        choose: takes the text of a scenario.
        end: ends the program.
    """

    def __init__(self, voice: Voice, choose: Callable[[str], None], end: Callable[[], None]) -> None:
        self._voice, self._choose, self._end = voice, choose, end
        self._rest = b""

    def read(self, fd: int) -> bool:
        """Obey what is there; False at its end."""
        try:
            data = os.read(fd, 4096)
        except OSError:  # a terminal in which another program is in front
            return False
        *lines, self._rest = (self._rest + data).split(b"\n")
        if not data:
            lines, self._rest = [self._rest], b""
        for line in lines:
            self.obey(line.decode(errors="replace").strip())
        return bool(data)

    def obey(self, line: str) -> None:
        """One command; an empty one does nothing."""
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
