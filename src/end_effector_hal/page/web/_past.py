"""The recordings of a folder, for the live page; separate processes of lower priority list and read them."""

from __future__ import annotations

import asyncio
import os
import re
import resource
import signal
import sys
from contextlib import suppress
from pathlib import Path

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.page import page_html
from end_effector_hal.page.recorded import PROGRESS

_NICE = 10
"""Niceness: a tenth of the processor beside a busy process, so no tool is late and reading still advances."""
MOST_CPU_S = 180
"""Processor time limit, independent of other load; half an hour of a tool needs 20 s."""
_MOST_BYTES = 4 << 30
"""Address space limit, bytes; half an hour of a tool at 50 Hz needs a quarter of it."""


def step_back(pid: int, *, session: bool = False) -> None:
    """Lower the priority of a process that has not started its threads yet.

    Args:
        pid: id of the process.
        session: whether it leads its own session: Linux may share the processor between sessions first (autogroup),
            and within them by niceness.
    """
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, max(_NICE, os.getpriority(os.PRIO_PROCESS, pid)))
    if session:
        with suppress(OSError):
            Path(f"/proc/{pid}/autogroup").write_text(str(_NICE), encoding="ascii")


def bound(pid: int) -> None:
    """Limit a reader's memory and processor time, so that a huge recording ends only its reader."""
    cpu = (MOST_CPU_S, MOST_CPU_S + 5)  # at the first it gets SIGXCPU, which says why it ended
    for limit, most in ((resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES)), (resource.RLIMIT_CPU, cpu)):
        with suppress(OSError):
            resource.prlimit(pid, limit, most)


LIST_S, READ_S = 60.0, 1800.0
"""Elapsed-time limits, seconds, for a file that hangs; a slow reader is ended by its processor-time limit."""
_ID = re.compile(r"[0-9a-f]{24}")
_MODULE = "end_effector_hal.page.recorded"
_PIECE = 65_536
_MOST = 8
"""Largest number of requests in progress; a further one is refused."""


class PastRecordings:
    """Lists and reads earlier recordings.

    Args:
        folder: the folder into which the tool records.
        description: description of the tool, for recordings without a trace.
    """

    def __init__(self, folder: Path, description: Path) -> None:
        self._folder, self._description = folder, description
        # who lists does not wait for who judges
        self._to_list, self._to_read = asyncio.Semaphore(1), asyncio.Semaphore(1)
        self._asked = 0
        self._tasks: dict[tuple[str, str], asyncio.Task[bytes]] = {}
        self._children: set[asyncio.subprocess.Process] = set()
        self._progress: dict[tuple[str, ...], float] = {}

    async def listing(self) -> bytes:
        """Return the list as JSON; raises UsageError."""
        return await self._ask(self._to_list, LIST_S, "list", str(self._folder))

    async def history(self) -> bytes:
        """Return how the grips of the recordings change over time, as JSON; raises UsageError."""
        return await self._ask(self._to_read, READ_S, "history", str(self._folder), str(self._description))

    def reading(self, id_: str, *, verdict: bool) -> asyncio.Task[bytes] | None:
        """Return the task that reads or judges a recording and may raise UsageError; None: malformed id."""
        if not _ID.fullmatch(id_):
            return None
        key = (id_, "judge" if verdict else "show")
        task = self._tasks.get(key)
        if task is None:
            words = key[1], str(self._folder), str(self._description), id_
            task = self._tasks[key] = asyncio.create_task(self._ask(self._to_read, READ_S, *words))
            task.add_done_callback(lambda done: done.cancelled() or done.exception())  # a page may have gone
            for old in [each for each in self._tasks if each[0] != id_ and self._tasks[each].done()]:
                del self._tasks[old]  # one recording is kept
        return task

    def progress(self, id_: str, *, verdict: bool) -> float | None:
        """Return the share that is read, 0 to 1; None if unknown."""
        word = "judge" if verdict else "show"
        return self._progress.get((word, str(self._folder), str(self._description), id_))

    def forget(self, id_: str) -> None:
        """Discard the finished results for a recording that is opened, since it may have grown."""
        for key in [each for each in self._tasks if each[0] == id_ and self._tasks[each].done()]:
            del self._tasks[key]

    def close(self) -> None:
        """Cancel all reading."""
        for task in self._tasks.values():
            task.cancel()
        for child in self._children:
            with suppress(ProcessLookupError):
                child.kill()

    async def _ask(self, turn: asyncio.Semaphore, most_s: float, *words: str) -> bytes:
        if self._asked >= _MOST:
            raise UsageError("Other recordings are being read: try again.")
        self._asked += 1
        try:
            async with turn:
                return await self._answer(most_s, words)
        finally:
            self._asked -= 1

    async def _answer(self, most_s: float, words: tuple[str, ...]) -> bytes:
        pipe, nothing = asyncio.subprocess.PIPE, asyncio.subprocess.DEVNULL
        child = await asyncio.create_subprocess_exec(
            sys.executable,
            "-P",  # nothing of the current folder, which may hold somebody's recording
            "-m",
            _MODULE,
            *words,
            stdin=nothing,
            stdout=pipe,
            stderr=pipe,
            start_new_session=True,
        )
        step_back(child.pid, session=True)
        bound(child.pid)
        self._children.add(child)
        try:
            out, said = await asyncio.wait_for(self._heard(child, words), most_s)
        except TimeoutError:
            raise UsageError(f"The recording was not read within {most_s:g} s.") from None
        finally:
            if child.returncode is None:
                with suppress(ProcessLookupError):
                    child.kill()
                await child.wait()
            self._children.discard(child)
            self._progress.pop(words, None)
        if child.returncode == -signal.SIGXCPU:
            raise UsageError(f"The recording was not read within {MOST_CPU_S} s of processor time.")
        if child.returncode:
            known = child.returncode == 2 and said
            raise UsageError(
                said if known else "The recording cannot be read: the process that reads it has ended."
            )
        return out

    async def _heard(self, child: asyncio.subprocess.Process, words: tuple[str, ...]) -> tuple[bytes, str]:
        """Return the process's output, and its last line on stderr that is not progress."""
        assert child.stdout is not None
        assert child.stderr is not None
        printed = asyncio.ensure_future(child.stdout.read())
        said, rest = "", b""
        while piece := await child.stderr.read(_PIECE):
            *lines, rest = (rest + piece)[-_PIECE:].split(b"\n")
            for line in lines:
                text = line.decode(errors="replace").strip()
                if text.startswith(PROGRESS):
                    with suppress(ValueError):
                        self._progress[words] = float(text.removeprefix(PROGRESS))
                elif text:
                    said = text
        await child.wait()
        return await printed, said


def page_response(title: str, *, recorded: bool, csrf: str = "") -> Response:
    """Return the page itself."""
    return Response(page_html(title, recorded=recorded, csrf=csrf), media_type="text/html; charset=utf-8")


def task_response(task: asyncio.Task[bytes], progress: float | None) -> Response:
    """Return the JSON that a task has made; while it works the share that is done, 0 to 1 (None: unknown)."""
    if not task.done():
        return JSONResponse({"progress": progress}, 202)
    try:
        return Response(task.result(), media_type="application/json")
    except ReportedError as error:
        return PlainTextResponse(f"{error}\n", 404 if "no such recording" in str(error) else 500)


def no_recording() -> Response:
    """Return the answer to a request for a recording that does not exist."""
    return PlainTextResponse("There is no such recording.\n", 404)


HISTORY = "/history"


def past_routes(past: PastRecordings) -> list[Route]:
    """Return ``/past``, ``/history`` and the routes below it; the addresses contain ids and no paths."""

    async def of_all(request: Request) -> Response:
        try:
            found = await (past.history() if request.url.path == HISTORY else past.listing())
            return Response(found, media_type="application/json")
        except ReportedError as error:
            return PlainTextResponse(f"{error}\n", 503)

    async def page(request: Request) -> Response:
        past.forget(request.path_params["id"])
        return page_response("Recording", recorded=True)

    async def overview(_: Request) -> Response:
        return JSONResponse({"count": 1, "grown": False})

    async def answer(request: Request) -> Response:
        id_, verdict = request.path_params["id"], request.url.path.endswith("/verdict")
        task = past.reading(id_, verdict=verdict)
        return no_recording() if task is None else task_response(task, past.progress(id_, verdict=verdict))

    return [
        Route("/past", of_all),
        Route(HISTORY, of_all),
        Route("/past/{id}/", page),
        Route("/past/{id}/recordings", overview),
        Route("/past/{id}/recording/0", answer),
        Route("/past/{id}/recording/0/verdict", answer),
    ]
