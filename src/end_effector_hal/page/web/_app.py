"""The routes for the page, its files, its events, and commands."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from typing import Annotated, Any, NamedTuple

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from end_effector_hal.control import Answer
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import MOST_TEXT
from end_effector_hal.page import static_file
from end_effector_hal.page.view import ToolView
from end_effector_hal.runtime.stream import MAINTENANCE_WORDS
from end_effector_hal.vocabulary import display_name
from end_effector_hal.wires import now_us

from ._control import FAULT_WORDS, ControlLease, FaultCommands
from ._guard import METRICS, Asked, Guard, PageAddress
from ._hub import Hub
from ._metrics import TYPE, ToolMetrics
from ._past import PastRecordings, page_response, past_routes

Ask = Callable[[str, str], Awaitable[Answer]]
LONGEST = 2_000
"""Largest POST, bytes."""
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
    """Body of a POST: the page's id and a word; what is named, or the scenario of a fault."""

    page: str
    word: str
    name: str = ""
    """Of the actuator in maintenance, or the part that is to be gripped."""
    scenario: Annotated[str, Field(max_length=MOST_TEXT)] = ""


_POST = TypeAdapter(PagePost)


class Guarded:
    """Checks every request by the guard, and adds the security headers to every answer.

    Args:
        app: the application that is served.
    """

    def __init__(self, app: ASGIApp, address: PageAddress) -> None:
        self._app, self.address, self._guard = app, address, Guard(address)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            return
        request = Request(scope)
        headers = {name.lower(): value for name, value in request.headers.items()}
        cookie = request.cookies.get(self.address.cookie, "")
        asked = Asked(
            request.method, request.url.path, headers, cookie, request.query_params.get("token", "")
        )
        serve: ASGIApp = self._app
        if (refusal := self._guard.refuse(asked)) is not None:
            serve = PlainTextResponse(f"{refusal.why}\n", refusal.status)
        elif self._guard.lets_in(asked):
            serve = RedirectResponse("/", 303)
            serve.set_cookie(
                self.address.cookie, self.address.session, httponly=True, samesite="lax", path="/"
            )

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                found = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    found[name] = value
            await send(message)

        await serve(scope, receive, with_headers)


def make_app(
    address: PageAddress,
    view: ToolView,
    ask: Ask,
    hub: Hub,
    control: ControlLease,
    faults: FaultCommands,
    past: PastRecordings,
) -> ASGIApp:
    """Return the application.

    Args:
        address: the address with its access secrets.
        ask: sends a command to the tool.
        hub: the open pages.
        control: the lease of the page that commands.
        faults: fault commands for a testbench.
        past: earlier recordings.
    """
    served = _Served(address, view, ask, hub, control, faults)
    routes = [
        Route("/", served.page),
        Route("/static/{name}", static_route),
        Route("/events", served.events),
        Route(METRICS, served.metrics),
        Route("/command", served.command, methods=["POST"]),
        Route("/fault", served.fault, methods=["POST"]),
        Route("/control", served.control, methods=["POST"]),
        *past_routes(past),
    ]
    return Guarded(Starlette(routes=routes), address)


async def static_route(request: Request) -> Response:
    """Serve a static file of the page."""
    name = request.path_params["name"]
    kind = name.rpartition(".")[2]
    content = static_file(name) if kind in _TYPES else None
    if content is None:
        return PlainTextResponse("There is no such file.\n", 404)
    return Response(content, media_type=f"{_TYPES[kind]}; charset=utf-8")


class _Served(NamedTuple):
    """The routes of a live tool; the fields are those of `make_app`."""

    address: PageAddress
    view: ToolView
    ask: Ask
    hub: Hub
    lease: ControlLease
    faults: FaultCommands

    async def page(self, _: Request) -> Response:
        return page_response(self.view.description.name, recorded=False, csrf=self.address.csrf)

    async def metrics(self, _: Request) -> Response:
        return Response(ToolMetrics(self.view, now_us).text(), media_type=TYPE)

    async def events(self, request: Request) -> Response:
        page = request.query_params.get("page", "")
        if not _PAGE.fullmatch(page):
            return PlainTextResponse("The parameter page must be 16 to 32 hexadecimal digits.\n", 400)
        try:
            visitor = self.hub.enter(page)
        except UsageError as error:
            return PlainTextResponse(f"{error}\n", 503)
        return StreamingResponse(self.hub.events(visitor), media_type="text/event-stream")

    async def control(self, request: Request) -> Response:
        posted = await _posted(request)
        if posted is None:
            return _malformed()
        at, answer = now_us(), Answer(True)
        if posted.word == "take":
            answer = self.lease.take(posted.page, self.hub.name_of(posted.page), at)
        elif posted.word == "renew":
            held = self.lease.renew(posted.page, at)
            answer = Answer(held, "" if held else "The control was lost: this page was silent for too long.")
        elif posted.word == "release":
            self.lease.release(posted.page, at)
        else:
            return _malformed()
        return _as_json(answer)

    async def command(self, request: Request) -> Response:
        posted = await _posted(request)
        if posted is None or not self._known(posted):
            return _malformed()
        at, who = now_us(), self.hub.name_of(posted.page)
        # a page without control may stop the tool, too
        if posted.word not in ("cancel", "stop") and self.lease.holder(at) != posted.page:
            return _as_json(Answer(False, TAKE_CONTROL))
        name = posted.name if posted.word == "grip" else display_name(posted.name)
        return await self._logged(who, f"{posted.word} {name}".rstrip(), self.ask(posted.word, posted.name))

    async def fault(self, request: Request) -> Response:
        posted = await _posted(request)
        if posted is None or posted.word not in FAULT_WORDS:
            return _malformed()
        who = self.hub.name_of(posted.page)
        if self.lease.holder(now_us()) != posted.page:
            return _as_json(Answer(False, TAKE_CONTROL))
        what = f"{posted.word} {posted.scenario}".rstrip()
        asked = self.faults.obey(posted.word, posted.page, who, posted.scenario, now_us)
        return await self._logged(who, f"fault, {what}", asked)

    async def _logged(self, who: str, what: str, asked: Awaitable[Answer]) -> Response:
        self.view.log.add(now_us(), "page", f"{who}: {what}.")
        answer = await asked
        if not answer.accepted:
            self.view.log.add(now_us(), "refusal", f"{who}, {what}: {answer.reason}")
        return _as_json(answer)

    def _known(self, posted: PagePost) -> bool:
        if posted.word in MAINTENANCE_WORDS:
            return posted.name in self.view.description.actuators
        known = self.view.description.parts if posted.word == "grip" else ()
        return posted.word in self.view.buttons and (not posted.name or posted.name in known)


async def _posted(request: Request) -> PagePost | None:
    body = b""
    try:
        async for part in request.stream():
            body += part
            if len(body) > LONGEST:
                return None
        posted = _POST.validate_json(body)
    except (ValidationError, ClientDisconnect):  # half a command is none
        return None
    return posted if _PAGE.fullmatch(posted.page) else None


def _malformed() -> Response:
    return PlainTextResponse(
        "Expected is {page, word} as JSON, with a word that is known; {name} for an actuator or a part, for faults "
        f"{{scenario}} of at most {MOST_TEXT} letters.\n",
        400,
    )


def _as_json(answer: Answer) -> Response:
    content: dict[str, Any] = {
        "accepted": answer.accepted,
        "reason": answer.reason,
        "decided": answer.decided,
    }
    return JSONResponse(content)
