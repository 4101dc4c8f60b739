"""One program's socket: records in, commands out."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from end_effector_hal.control import Answer
from end_effector_hal.runtime.boundary import STREAMED

from ._socket_link import Lost, SocketLink

Taken = Callable[[str, int, Any], None]


class ProgramLink(SocketLink):
    """Reads records and passes them on; asks commands and waits for their answers.

    Args:
        path: of the socket.
        program: its name, for sentences.
        take: gets kind, time and content of each record; raises ReportedError for one that does not fit.
        lost: gets the reason when the connection is gone.
    """

    def __init__(self, path: Path, program: str, take: Taken, lost: Lost) -> None:
        super().__init__(path, f"The {program} program", lost)
        self._taken = take

    @property
    def missing(self) -> str:
        return f"{self._who} does not run, or nothing shows it ({self._path})."

    async def ask(self, word: str, actuator: str = "") -> Answer:
        """Ask for a command, in maintenance of one actuator; an answer in any case."""
        return await self.request(command=word, actuator=actuator)

    def read(self, message: dict[str, Any]) -> None:
        kind = message["kind"]
        content = _adapter(kind).validate_python(message["content"]) if kind in STREAMED else None
        self._taken(kind, int(message["at"]), content)


@cache
def _adapter(kind: str) -> TypeAdapter[Any]:
    return TypeAdapter(STREAMED[kind])
