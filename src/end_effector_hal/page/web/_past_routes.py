"""The live page's routes for recordings: their list, and a page for each recording; all of them only read."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from end_effector_hal.errors import ReportedError
from end_effector_hal.page import page_html

from ._past import PastRecordings


def past_routes(past: PastRecordings) -> list[Route]:
    """Return ``/past`` and the routes below it; the addresses contain ids and no paths."""

    async def listing(_: Request) -> Response:
        try:
            return Response(await past.listing(), media_type="application/json")
        except ReportedError as error:
            return PlainTextResponse(f"{error}\n", 503)

    async def page(request: Request) -> Response:
        past.forget(request.path_params["id"])
        return Response(page_html("Recording", recorded=True), media_type="text/html; charset=utf-8")

    async def overview(_: Request) -> Response:
        return JSONResponse({"count": 1, "grown": False})

    async def document(request: Request) -> Response:
        return await answer(request, verdict=False)

    async def verdict(request: Request) -> Response:
        return await answer(request, verdict=True)

    async def answer(request: Request, *, verdict: bool) -> Response:
        task = past.reading(request.path_params["id"], verdict=verdict)
        if task is None:
            return PlainTextResponse("There is no such recording.\n", 404)
        if not task.done():
            progress = past.progress(request.path_params["id"], verdict=verdict)
            return JSONResponse({"progress": progress}, 202)
        try:
            return Response(task.result(), media_type="application/json")
        except ReportedError as error:
            return PlainTextResponse(f"{error}\n", 404 if "no such recording" in str(error) else 500)

    return [
        Route("/past", listing),
        Route("/past/{id}/", page),
        Route("/past/{id}/recordings", overview),
        Route("/past/{id}/recording/0", document),
        Route("/past/{id}/recording/0/verdict", verdict),
    ]
