"""The routes for recordings: page, files, documents, and the replay's results; none accepts a command."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from pydantic_core import to_json
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from end_effector_hal.page.recorded import (
    ComparedRecording,
    RecordedTables,
    RecordingFiles,
    RecordingPart,
    compare_recordings,
    judge_recording,
    read_recording,
)

from ._app import Guarded, static_route
from ._guard import PageAddress
from ._past import no_recording, page_response, task_response


class ServedRecording:
    """One recording, read in a thread at the first request, and again after `refresh`.

    Args:
        files: its traces.
        part: the part that is shown.

    Attributes:
        compared: the data for a comparison; None: it has not been read, or cannot be.
    """

    def __init__(self, files: RecordingFiles | RecordedTables, part: RecordingPart) -> None:
        self._files, self._part = files, part
        self.progress = 0.0
        self.compared: ComparedRecording | None = None
        self._again = False
        self._read: asyncio.Task[bytes] | None = None
        self._judged: asyncio.Task[bytes] | None = None

    @property
    def name(self) -> str:
        """Name of the folder or the file."""
        return self._files.name

    @property
    def grown(self) -> bool:
        """Whether the recording has changed since it was read."""
        return self._files.grown

    def refresh(self) -> None:
        """Arrange to read the recording again if it has grown; called when the page is loaded."""
        if self._read is not None and self._read.done() and self.grown:
            self._read = self._judged = None
            self._again = True

    def document(self) -> asyncio.Task[bytes]:
        """Return the task for its document as JSON; the task raises ReportedError."""
        if self._read is None:
            self._read = asyncio.create_task(asyncio.to_thread(self._make))
        return self._read

    def verdict(self) -> asyncio.Task[bytes]:
        """Return the task for the replay's result as JSON."""
        if self._judged is None:
            self._judged = asyncio.create_task(self._judge(self.document()))
        return self._judged

    def cancel(self) -> None:
        """Cancel both tasks."""
        for task in (self._read, self._judged):
            if task is not None:
                task.cancel()

    def _make(self) -> bytes:
        if self._again:
            self._files = self._files.again()
        read = read_recording(self._files, self._part, self._note)
        self.compared = read.compared
        return to_json(read.document, fallback=dict)

    async def _judge(self, first: asyncio.Task[bytes]) -> bytes:
        await asyncio.wait([first])
        return to_json(await asyncio.to_thread(judge_recording, self._files))

    def _note(self, progress: float) -> None:
        self.progress = progress


class ServedDifferences:
    """The differences between two recordings, computed in a thread on request, and again if one is read again."""

    def __init__(self) -> None:
        self._of: tuple[asyncio.Task[bytes], ...] = ()
        self._found: asyncio.Task[bytes] | None = None

    def of(self, first: ServedRecording, second: ServedRecording) -> asyncio.Task[bytes]:
        """Return the task for the differences as JSON; it raises ReportedError if a recording cannot be read."""
        documents = first.document(), second.document()
        if self._found is None or documents != self._of:
            self._of, self._found = documents, asyncio.create_task(self._find(documents, first, second))
        return self._found

    async def _find(
        self, documents: tuple[asyncio.Task[bytes], ...], first: ServedRecording, second: ServedRecording
    ) -> bytes:
        for each in documents:
            await asyncio.wait([each])
            each.result()
        assert first.compared is not None
        assert second.compared is not None
        return to_json(await asyncio.to_thread(compare_recordings, first.compared, second.compared))


def make_recordings_app(address: PageAddress, recordings: Sequence[ServedRecording]) -> ASGIApp:
    """Return the application.

    Args:
        address: the address with its access secrets.
        recordings: one, or two to compare.
    """
    shown = list(recordings)
    served = ServedDifferences()

    async def page(_: Request) -> Response:
        for each in shown:
            each.refresh()
        return page_response(" and ".join(each.name for each in shown), recorded=True, csrf=address.csrf)

    async def overview(_: Request) -> Response:
        return JSONResponse({"count": len(shown), "grown": any(each.grown for each in shown)})

    async def answer(request: Request) -> Response:
        # as text: Python converts no number of thousands of digits
        asked = {str(number): each for number, each in enumerate(shown)}.get(request.path_params["number"])
        if asked is None:
            return no_recording()
        verdict = request.url.path.endswith("/verdict")
        return task_response(asked.verdict() if verdict else asked.document(), asked.progress)

    async def differences(_: Request) -> Response:
        if len(shown) != 2:
            return PlainTextResponse("There is one recording here: nothing is compared.\n", 404)
        return task_response(served.of(*shown), None)

    routes = [
        Route("/", page),
        Route("/static/{name}", static_route),
        Route("/recordings", overview),
        Route("/differences", differences),
        Route("/recording/{number}", answer),
        Route("/recording/{number}/verdict", answer),
    ]
    return Guarded(Starlette(routes=routes), address)
