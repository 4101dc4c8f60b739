"""Clients of the page that are silent, drip, or do not read: they keep nobody else out."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from end_effector_hal.page.web import _serve
from end_effector_hal.page.web._serve import MOST_CONNECTIONS, BoundedConnection
from tests.support.patience import wait_until

pytestmark = pytest.mark.wall
PATIENCE_S = 1.0
LARGE = 60_000_000
ASK = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"


async def hello(_: Request) -> Response:
    return PlainTextResponse("hello")


async def large(_: Request) -> Response:
    return PlainTextResponse("x" * LARGE)


async def slow(_: Request) -> Response:
    await asyncio.sleep(3 * PATIENCE_S)
    return PlainTextResponse("late")


async def events(_: Request) -> Response:
    async def forever() -> object:
        while True:
            yield b"data: 1\n\n"
            await asyncio.sleep(0.05)

    return StreamingResponse(forever())  # type: ignore[arg-type]


async def flood(_: Request) -> Response:
    async def forever() -> object:
        while True:
            yield b"x" * 100_000
            await asyncio.sleep(0.01)

    return StreamingResponse(forever())  # type: ignore[arg-type]


class Page:
    def __init__(self) -> None:
        routes = [Route(f"/{each.__name__}", each) for each in (large, slow, events, flood)]
        app = Starlette(routes=[Route("/", hello), *routes])
        self.listener = socket.create_server(("127.0.0.1", 0))
        config = uvicorn.Config(
            app, http=BoundedConnection, log_level="error", lifespan="off", timeout_graceful_shutdown=1
        )
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(target=self.server.run, args=([self.listener],))
        self.thread.start()

    def connect(self, *, buffer: int | None = None) -> socket.socket:
        client = socket.socket()
        if buffer is not None:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        client.settimeout(10)
        client.connect(self.listener.getsockname())
        return client

    def answers(self, path: str = "/") -> bool:
        with self.connect() as client:
            try:
                client.sendall(ASK.replace(b"/ ", path.encode() + b" ", 1))
                return client.recv(100).startswith(b"HTTP/1.1 200")
            except ConnectionError:
                return False

    @property
    def open(self) -> int:
        return len(self.server.server_state.connections)


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    monkeypatch.setattr(_serve, "REQUEST_S", PATIENCE_S)
    monkeypatch.setattr(_serve, "STALL_S", PATIENCE_S)
    monkeypatch.setattr(_serve, "LOOK_S", 0.1)
    made = Page()
    yield made
    made.server.should_exit = True
    made.thread.join(10)
    made.listener.close()
    assert not made.thread.is_alive()


def test_silent_clients_make_room_for_one_who_asks(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_serve, "REQUEST_S", 600.0)  # none of them is sent away for its time-out
    with ExitStack() as stack:
        for _ in range(2 * MOST_CONNECTIONS):
            stack.enter_context(page.connect())
        assert page.answers()  # so all before it have been seen, too
        # many come at once: those that make room for them are gone a moment later
        wait_until("not more are left than may be", lambda: page.open <= MOST_CONNECTIONS)


def test_silent_clients_are_sent_away_in_the_end(page: Page) -> None:
    with ExitStack() as stack:
        silent = [stack.enter_context(page.connect()) for _ in range(3)]
        wait_until("they are there", lambda: page.open == len(silent))
        wait_until("all of them are gone", lambda: page.open == 0)


def test_those_who_are_served_are_not_sent_away_for_silent_ones(page: Page) -> None:
    with ExitStack() as stack:
        follower = stack.enter_context(page.connect())
        follower.sendall(ASK.replace(b"/ ", b"/events ", 1))
        assert follower.recv(100)
        for _ in range(2 * MOST_CONNECTIONS):
            stack.enter_context(page.connect())
        end = time.monotonic() + 2 * PATIENCE_S
        while time.monotonic() < end:
            assert follower.recv(1000)


@pytest.mark.parametrize(
    "piece",
    [b"GET / HTTP/1.1\r\nHost: a\r\n", b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 500\r\n\r\n"],
    ids=["headers", "body"],
)
def test_a_request_that_drips_in_ends(page: Page, piece: bytes) -> None:
    with page.connect() as client:
        client.sendall(piece)

        def sent_away() -> bool:
            try:
                client.sendall(b"x")
            except OSError:
                return True
            time.sleep(0.05)
            return False

        wait_until("it is sent away", sent_away, timeout_s=5 * PATIENCE_S)


@pytest.mark.parametrize("path", [b"/large ", b"/flood "])
def test_who_reads_nothing_is_dropped(page: Page, path: bytes) -> None:
    with page.connect(buffer=4096) as client:
        client.sendall(ASK.replace(b"/ ", path, 1))
        wait_until("it is served", lambda: page.open == 1)
        wait_until("it is dropped", lambda: page.open == 0, timeout_s=20 * PATIENCE_S)


def test_a_large_answer_may_take_its_time_and_so_may_the_page(page: Page) -> None:
    with page.connect() as client:
        client.sendall(ASK.replace(b"/ ", b"/large ", 1))
        got, end = 0, time.monotonic() + 3 * PATIENCE_S
        while time.monotonic() < end:
            got += len(client.recv(200_000))
            time.sleep(0.02)
        while got < LARGE:
            piece = client.recv(1_000_000)
            assert piece, "sent away while it read"
            got += len(piece)
    assert page.answers("/slow")
