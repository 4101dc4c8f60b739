"""One program's socket: found again whenever it comes back."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from end_effector_hal.control import Answer
from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime.boundary import STREAMED
from end_effector_hal.wires import now_us

AGAIN_S = 0.3
ANSWER_S = 4.0
VALID_US = 1_000_000
"""A command that its program has not begun by then is not executed."""
LONGEST = 4_000_000
"""Bytes of a record."""

Taken = Callable[[str, int, Any], None]
Lost = Callable[[str], None]


class ProgramLink:
    """Reads records and passes them on; asks commands and waits for their answers.

    Args:
        path: of the socket.
        program: its name, for sentences.
        take: gets kind, time and content of each record; raises ReportedError for one that does not fit.
        lost: gets the reason when the connection is gone.
    """

    def __init__(self, path: Path, program: str, take: Taken, lost: Lost) -> None:
        self._path, self._program, self._take, self._lost = path, program, take, lost
        self._writer: asyncio.StreamWriter | None = None
        self._count = 0
        self._asked: dict[int, asyncio.Future[Answer]] = {}

    async def run(self) -> None:
        """Follow the program until it is cancelled."""
        while True:
            try:
                await self._follow()
                why = f"The {self._program} program has ended its connection."
            except (FileNotFoundError, ConnectionRefusedError):
                why = f"The {self._program} program does not run, or nothing shows it ({self._path})."
            except ReportedError as error:
                why = str(error)
            except OSError as error:
                why = f"The {self._program} program cannot be read: {error.strerror or error} ({self._path})."
            except ValueError as error:  # longer than any record
                why = f"The {self._program} program sends what is no record: {error}."
            finally:
                self._end()
            self._lost(why)
            await asyncio.sleep(AGAIN_S)

    async def ask(self, word: str) -> Answer:
        """Ask for a command; an answer in any case."""
        unheard = Answer(False, f"The {self._program} program is not heard.")
        if self._writer is None:
            return unheard
        self._count += 1
        number, answer = self._count, asyncio.get_running_loop().create_future()
        message = {"id": number, "command": word, "until_us": now_us() + VALID_US}
        self._asked[number] = answer
        try:
            self._writer.write(json.dumps(message).encode() + b"\n")
            return await asyncio.wait_for(answer, ANSWER_S)
        except OSError:
            return unheard
        except TimeoutError:
            silent = f"The {self._program} program does not answer: what became of the command is unknown."
            return Answer(False, silent, decided=False)
        finally:
            self._asked.pop(number, None)

    async def _follow(self) -> None:
        reader, writer = await asyncio.open_unix_connection(self._path, limit=LONGEST)
        self._writer = writer
        while line := await reader.readline():
            self._read(line)

    def _read(self, line: bytes) -> None:
        try:
            message = json.loads(line)
            kind = message["kind"]
            if kind == "answer-to":
                answer = Answer(bool(message["accepted"]), str(message["reason"]), bool(message["decided"]))
                if (asked := self._asked.get(message["id"])) is not None and not asked.done():
                    asked.set_result(answer)
                return
            content = _adapter(kind).validate_python(message["content"]) if kind in STREAMED else None
            self._take(kind, int(message["at"]), content)
        except Exception as error:  # noqa: BLE001 of another release, or of nobody: it ends this connection only
            what = f"A record of the {self._program} program cannot be read: {error}"
            raise ReportedError(what[:300]) from None

    def _end(self) -> None:
        writer, self._writer = self._writer, None
        if writer is not None:
            with suppress(OSError):
                writer.close()
        for asked in self._asked.values():
            if not asked.done():
                gone = f"The {self._program} program has gone: what became of the command is unknown."
                asked.set_result(Answer(False, gone, decided=False))


@cache
def _adapter(kind: str) -> TypeAdapter[Any]:
    return TypeAdapter(STREAMED[kind])
