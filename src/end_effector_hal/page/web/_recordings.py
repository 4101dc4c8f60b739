"""The routes of recordings: the page, its files, the documents, what the replay says. Nothing here takes a command."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from pydantic_core import to_json
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from end_effector_hal.errors import ReportedError
from end_effector_hal.page._html import page_html
from end_effector_hal.page.recorded import (
    RecordedTables,
    RecordingFiles,
    RecordingPart,
    judge_recording,
    read_recording,
)

from ._address import PageAddress
from ._app import Guarded, static_route


class ServedRecording:
    """One recording, read in a thread when it is first asked for, and again after `refresh`.

    Args:
        files: its traces.
        part: what of it is shown.
    """

    def __init__(self, files: RecordingFiles | RecordedTables, part: RecordingPart) -> None:
        self._files, self._part = files, part
        self.progress = 0.0
        self._again = False
        self._read: asyncio.Task[bytes] | None = None
        self._judged: asyncio.Task[bytes] | None = None

    @property
    def name(self) -> str:
        """Of the folder or the file."""
        return self._files.name

    @property
    def grown(self) -> bool:
        """Whether it is another one than was read."""
        return self._files.grown

    def refresh(self) -> None:
        """Somebody loads the page: what was read long ago is read again, if there is more by now."""
        if self._read is not None and self._read.done() and self.grown:
            self._read = self._judged = None
            self._again = True

    def document(self) -> asyncio.Task[bytes]:
        """Its document as JSON; the task raises ReportedError."""
        if self._read is None:
            self._read = asyncio.create_task(asyncio.to_thread(self._make))
        return self._read

    def verdict(self) -> asyncio.Task[bytes]:
        """What the replay says, as JSON."""
        if self._judged is None:
            self._judged = asyncio.create_task(self._judge(self.document()))
        return self._judged

    def cancel(self) -> None:
        """Nobody waits any more."""
        for task in (self._read, self._judged):
            if task is not None:
                task.cancel()

    def _make(self) -> bytes:
        if self._again:
            self._files = self._files.again()
        return to_json(read_recording(self._files, self._part, self._note), fallback=dict)

    async def _judge(self, first: asyncio.Task[bytes]) -> bytes:
        await asyncio.wait([first])
        return to_json(await asyncio.to_thread(judge_recording, self._files))

    def _note(self, progress: float) -> None:
        self.progress = progress


def make_recordings_app(address: PageAddress, recordings: Sequence[ServedRecording]) -> ASGIApp:
    """The application.

    Args:
        address: who may come.
        recordings: one, or two to compare.
    """

    async def page(_: Request) -> Response:
        for each in recordings:
            each.refresh()
        title = " and ".join(each.name for each in recordings)
        return Response(page_html(title, recorded=True), media_type="text/html; charset=utf-8")

    async def overview(_: Request) -> Response:
        return JSONResponse({"count": len(recordings), "grown": any(each.grown for each in recordings)})

    async def document(request: Request) -> Response:
        return await _answer(request, verdict=False)

    async def verdict(request: Request) -> Response:
        return await _answer(request, verdict=True)

    async def _answer(request: Request, *, verdict: bool) -> Response:
        # as text: Python converts no number of thousands of digits
        asked = {str(number): each for number, each in enumerate(recordings)}.get(
            request.path_params["number"]
        )
        if asked is None:
            return PlainTextResponse("There is no such recording.\n", 404)
        task = asked.verdict() if verdict else asked.document()
        if not task.done():
            return JSONResponse({"progress": asked.progress}, 202)
        try:
            return Response(task.result(), media_type="application/json")
        except ReportedError as error:
            return PlainTextResponse(f"{error}\n", 500)

    routes = [
        Route("/", page),
        Route("/static/{name}", static_route),
        Route("/recordings", overview),
        Route("/recording/{number}", document),
        Route("/recording/{number}/verdict", verdict),
    ]
    return Guarded(Starlette(routes=routes), address)
