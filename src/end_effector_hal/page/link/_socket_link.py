"""A local socket with JSON lines: found again whenever it comes back; questions with numbers, and their answers."""

from __future__ import annotations

import asyncio
import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from end_effector_hal.control import Answer
from end_effector_hal.errors import ReportedError
from end_effector_hal.wires import now_us

AGAIN_S = 0.3
ANSWER_S = 4.0
VALID_US = 1_000_000
"""What the other side has not begun by then is not executed."""
LONGEST = 4_000_000
"""Bytes of a message."""

Lost = Callable[[str], None]


class SocketLink(ABC):
    """Passes messages on; asks, and waits for answers.

    Args:
        path: of the socket.
        who: is at the other side, to begin a sentence.
        lost: gets the reason when the connection is gone, or cannot be made.
    """

    def __init__(self, path: Path, who: str, lost: Lost) -> None:
        self._path, self._who, self._lost = path, who, lost
        self._writer: asyncio.StreamWriter | None = None
        self._count = 0
        self._asked: dict[int, asyncio.Future[Answer]] = {}

    @abstractmethod
    def read(self, message: dict[str, Any]) -> None:
        """A message that is no answer; whatever it raises ends this connection only."""

    @property
    @abstractmethod
    def missing(self) -> str:
        """The reason when there is no socket, or nobody at it."""

    async def run(self) -> None:
        """Follow the socket until it is cancelled."""
        while True:
            try:
                await self._follow()
                why = f"{self._who} has ended its connection."
            except (FileNotFoundError, ConnectionRefusedError):
                why = self.missing
            except ReportedError as error:
                why = str(error)
            except OSError as error:
                why = f"{self._who} cannot be read: {error.strerror or error} ({self._path})."
            except ValueError as error:  # longer than any record
                why = f"{self._who} sends what is no record: {error}."
            finally:
                self._end()
            self._lost(why)
            await asyncio.sleep(AGAIN_S)

    async def request(self, **question: object) -> Answer:
        """Ask for something; an answer in any case."""
        unheard = Answer(False, f"There is no connection to {self._who[:1].lower()}{self._who[1:]}.")
        if self._writer is None:
            return unheard
        self._count += 1
        number, answer = self._count, asyncio.get_running_loop().create_future()
        message = {"id": number, **question, "until_us": now_us() + VALID_US}
        self._asked[number] = answer
        try:
            self._writer.write(to_json(message) + b"\n")
            return await asyncio.wait_for(answer, ANSWER_S)
        except OSError:
            return unheard
        except TimeoutError:
            silent = f"{self._who} does not answer: what became of the command is unknown."
            return Answer(False, silent, decided=False)
        finally:
            self._asked.pop(number, None)

    async def _follow(self) -> None:
        reader, writer = await asyncio.open_unix_connection(self._path, limit=LONGEST)
        self._writer = writer
        while line := await reader.readline():
            self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            message = json.loads(line)
            if message["kind"] == "answer-to":
                answer = Answer(bool(message["accepted"]), str(message["reason"]), bool(message["decided"]))
                if (asked := self._asked.get(message["id"])) is not None and not asked.done():
                    asked.set_result(answer)
                return
            self.read(message)
        except Exception as error:  # noqa: BLE001 of another release, or of nobody: it ends this connection only
            who = self._who[:1].lower() + self._who[1:]
            what = f"A record of {who} cannot be read: {error}"
            raise ReportedError(what[:300]) from None

    def _end(self) -> None:
        writer, self._writer = self._writer, None
        if writer is not None:
            with suppress(OSError):
                writer.close()
        for asked in self._asked.values():
            if not asked.done():
                gone = f"{self._who} has gone: what became of the command is unknown."
                asked.set_result(Answer(False, gone, decided=False))
