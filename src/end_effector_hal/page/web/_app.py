"""The routes: the page, its files, the events, commands."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from html import escape
from importlib.resources import files
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from end_effector_hal.control import Answer
from end_effector_hal.errors import UsageError
from end_effector_hal.page.view import ToolView
from end_effector_hal.wires import now_us

from ._address import PageAddress
from ._control import ControlLease
from ._guard import Asked, Guard
from ._hub import Hub

Ask = Callable[[str], Awaitable[Answer]]
LONGEST = 2_000
"""Bytes of a POST."""
_PAGE = re.compile(r"[0-9a-f]{16,32}")
_TYPES = {"js": "text/javascript", "css": "text/css", "svg": "image/svg+xml", "txt": "text/plain"}
_HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
TAKE_CONTROL = "Take control first."


@dataclass(frozen=True)
class PagePost:
    """What a page posts: who it is, and a word."""

    page: str
    word: str


_POST = TypeAdapter(PagePost)


class Guarded:
    """Nothing gets past the guard, and every answer has the headers.

    Args:
        app: what is served.
        address: of the page.
    """

    def __init__(self, app: ASGIApp, address: PageAddress) -> None:
        self._app, self._address, self._guard = app, address, Guard(address)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            return
        request = Request(scope)
        headers = {name.lower(): value for name, value in request.headers.items()}
        cookie = request.cookies.get(self._address.cookie, "")
        asked = Asked(
            request.method, request.url.path, headers, cookie, request.query_params.get("token", "")
        )
        serve: ASGIApp = self._app
        if (refusal := self._guard.refuse(asked)) is not None:
            serve = PlainTextResponse(f"{refusal.why}\n", refusal.status)
        elif self._guard.lets_in(asked):
            serve = RedirectResponse("/", 303)
            serve.set_cookie(
                self._address.cookie, self._address.session, httponly=True, samesite="lax", path="/"
            )

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                found = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    found[name] = value
            await send(message)

        await serve(scope, receive, with_headers)


def make_app(address: PageAddress, view: ToolView, ask: Ask, hub: Hub, control: ControlLease) -> ASGIApp:
    """The application.

    Args:
        address: who may come.
        view: what is shown.
        ask: gives a command to the tool.
        hub: those who look.
        control: which of them commands.
    """
    served = _Served(address, view, ask, hub, control)
    routes = [
        Route("/", served.page),
        Route("/static/{name}", served.file),
        Route("/events", served.events),
        Route("/command", served.command, methods=["POST"]),
        Route("/control", served.control, methods=["POST"]),
    ]
    return Guarded(Starlette(routes=routes), address)


class _Served:
    def __init__(
        self, address: PageAddress, view: ToolView, ask: Ask, hub: Hub, control: ControlLease
    ) -> None:
        self._address, self._view, self._ask, self._hub, self._control = address, view, ask, hub, control
        self._files = files("end_effector_hal.page") / "static"

    async def page(self, _: Request) -> Response:
        html = (self._files / "index.html").read_text()
        html = html.replace("{{csrf}}", self._address.csrf).replace(
            "{{title}}", escape(self._view.description.name)
        )
        return Response(html, media_type="text/html; charset=utf-8")

    async def file(self, request: Request) -> Response:
        name = request.path_params["name"]
        kind = name.rpartition(".")[2]
        if (
            not re.fullmatch(r"[A-Za-z][\w.-]*", name)
            or kind not in _TYPES
            or not (self._files / name).is_file()
        ):
            return PlainTextResponse("There is no such file.\n", 404)
        return Response((self._files / name).read_bytes(), media_type=f"{_TYPES[kind]}; charset=utf-8")

    async def events(self, request: Request) -> Response:
        page = request.query_params.get("page", "")
        if not _PAGE.fullmatch(page):
            return PlainTextResponse("A page has a number of its own.\n", 400)
        try:
            visitor = self._hub.enter(page)
        except UsageError as error:
            return PlainTextResponse(f"{error}\n", 503)
        return StreamingResponse(self._hub.events(visitor), media_type="text/event-stream")

    async def control(self, request: Request) -> Response:
        posted = await _posted(request)
        if posted is None:
            return _malformed()
        at, answer = now_us(), Answer(True)
        if posted.word == "take":
            answer = self._control.take(posted.page, self._hub.name_of(posted.page), at)
        elif posted.word == "renew":
            held = self._control.renew(posted.page, at)
            answer = Answer(held, "" if held else "The control was lost: this page was silent for too long.")
        elif posted.word == "release":
            self._control.release(posted.page, at)
        else:
            return _malformed()
        return _as_json(answer)

    async def command(self, request: Request) -> Response:
        posted = await _posted(request)
        if posted is None or posted.word not in self._view.buttons:
            return _malformed()
        at, who = now_us(), self._hub.name_of(posted.page)
        # whoever sees that a grip must end may end it
        if posted.word != "cancel" and self._control.holder(at) != posted.page:
            return _as_json(Answer(False, TAKE_CONTROL))
        self._view.log.add(at, "page", f"{who}: {posted.word}.", who)
        answer = await self._ask(posted.word)
        if not answer.accepted:
            self._view.log.add(
                now_us(), "refusal", f"{posted.word.capitalize()} of {who}: {answer.reason}", who
            )
        return _as_json(answer)


async def _posted(request: Request) -> PagePost | None:
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > LONGEST:
            return None
    try:
        posted = _POST.validate_json(body)
    except ValidationError:
        return None
    return posted if _PAGE.fullmatch(posted.page) else None


def _malformed() -> Response:
    return PlainTextResponse("Expected is {page, word} as JSON, with a word that is known.\n", 400)


def _as_json(answer: Answer) -> Response:
    content: dict[str, Any] = {
        "accepted": answer.accepted,
        "reason": answer.reason,
        "decided": answer.decided,
    }
    return JSONResponse(content)
