"""A client in an asyncio loop: it receives the records of a server and sends requests."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError

from ._client import LONGEST_LINE
from ._messages import Reply, adapter_of, read_answer, request_line

AGAIN_S = 0.3
GAP_S = 0.012
"""Shortest time between two requests, s: a server ends a connection that sends more than 100 lines in a second."""
ANSWER_S = 4.0
VALID_US = 1_000_000
"""Time within which the server must begin a request, µs; later it is not executed."""


class AsyncClient:
    """Receives records and sends requests; reconnects whenever the server is back.

    Args:
        path: the socket.
        who: the program that serves it, as the beginning of a sentence.
        table: the types of the records, by kind; for any other kind the content is None.
        take: called with kind, time and content of each record; an exception ends this connection.
        lost: called with the reason when the connection is lost or cannot be made.
        missing: the reason when no process serves the socket; default: a sentence.
    """

    def __init__(
        self,
        path: Path,
        who: str,
        table: Mapping[str, type],
        take: Callable[[str, int, Any], None],
        lost: Callable[[str], None],
        missing: str | None = None,
    ) -> None:
        self._path, self._who, self._table, self._pass_on, self._lost = path, who, table, take, lost
        self._inside = who[:1].lower() + who[1:]
        self._missing = f"{who} does not run, or has no socket ({path})." if missing is None else missing
        self._writer: asyncio.StreamWriter | None = None
        self._count = 0
        self._free_at = 0.0  # time of the loop at which the next request may be sent, s
        self._asked: dict[int | None, asyncio.Future[Reply]] = {}

    async def run(self) -> None:
        """Receive records until the task is cancelled."""
        while True:
            try:
                await self._follow()
                why = f"{self._who} has ended its connection."
            except (FileNotFoundError, ConnectionRefusedError):
                why = self._missing
            except ReportedError as error:
                why = str(error)
            except OSError as error:
                why = f"{self._who} cannot be read: {error.strerror or error} ({self._path})."
            except ValueError as error:  # of readline: longer than any record
                why = f"A record of {self._inside} cannot be read: {error}."
            finally:
                self._end()
            self._lost(why)
            await asyncio.sleep(AGAIN_S)

    async def request(self, **fields: object) -> Reply:
        """Send a request and await its answer; returns a reply in any case."""
        unsent = Reply(False, f"There is no connection to {self._inside}.")
        loop = asyncio.get_running_loop()
        wait_s = self._free_at - loop.time()
        self._free_at = max(self._free_at, loop.time()) + GAP_S
        if wait_s > 0:
            await asyncio.sleep(wait_s)
        if self._writer is None:
            return unsent
        self._count += 1
        number, answer = self._count, loop.create_future()
        self._asked[number] = answer
        try:
            self._writer.write(request_line(number, VALID_US, fields))
            return await asyncio.wait_for(answer, ANSWER_S)
        except TimeoutError:  # before OSError, of which it is one
            return self._unknown("does not answer")
        except OSError:
            return unsent
        finally:
            self._asked.pop(number, None)

    def _unknown(self, what: str) -> Reply:
        return Reply(
            False, f"{self._who} {what}: it is unknown whether the command was executed.", decided=False
        )

    async def _follow(self) -> None:
        reader, writer = await asyncio.open_unix_connection(self._path, limit=LONGEST_LINE)
        self._writer = writer
        while line := await reader.readline():
            self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            message = json.loads(line)
            if (answer := read_answer(message)) is None:
                kind = message["kind"]
                known = self._table.get(kind)
                content = None if known is None else adapter_of(known).validate_python(message["content"])
                self._pass_on(kind, int(message["at"]), content)
            elif (asked := self._asked.get(answer[0])) is not None and not asked.done():
                asked.set_result(answer[1])
        except ReportedError:  # who takes the records refuses this one, and says why
            raise
        except Exception as error:  # noqa: BLE001 of another release, or of anything: it ends this connection only
            raise ReportedError(f"A record of {self._inside} cannot be read: {error}"[:300]) from None

    def _end(self) -> None:
        writer, self._writer = self._writer, None
        if writer is not None:
            with suppress(OSError):
                writer.close()
        for asked in self._asked.values():
            if not asked.done():
                asked.set_result(self._unknown("has gone"))
