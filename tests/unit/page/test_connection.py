"""Clients of the page that are silent, drip, or do not read, and its own side of a testbench's socket."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, cast

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.page.link import TestbenchLink, ToolLink
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.page.web import _serve
from end_effector_hal.page.web._control import FaultCommands
from end_effector_hal.page.web._serve import MOST_CONNECTIONS, BoundedConnection
from end_effector_hal.wires import now_us
from end_effector_lab.testbench import Testbench, open_inputs, open_ports, write_virtual_copy
from end_effector_lab.testbench._faults import FaultServer
from tests.support.patience import PATIENCE_S, wait_until

SHORT_S = 1.0
LARGE = 60_000_000
ASK = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"


async def hello(_: Request) -> Response:
    return PlainTextResponse("hello")


async def large(_: Request) -> Response:
    return PlainTextResponse("x" * LARGE)


async def slow(_: Request) -> Response:
    await asyncio.sleep(3 * SHORT_S)
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
    monkeypatch.setattr(_serve, "REQUEST_S", SHORT_S)
    monkeypatch.setattr(_serve, "STALL_S", SHORT_S)
    monkeypatch.setattr(_serve, "LOOK_S", 0.1)
    made = Page()
    yield made
    made.server.should_exit = True
    made.thread.join(10)
    made.listener.close()
    assert not made.thread.is_alive()


@pytest.mark.wall
def test_silent_clients_make_room_for_one_who_asks(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_serve, "REQUEST_S", 600.0)  # none of them is sent away for its time-out
    with ExitStack() as stack:
        for _ in range(2 * MOST_CONNECTIONS):
            stack.enter_context(page.connect())
        assert page.answers()  # so all before it have been seen, too
        # many come at once: those that make room for them are gone a moment later
        wait_until("not more are left than may be", lambda: page.open <= MOST_CONNECTIONS)


@pytest.mark.wall
def test_silent_clients_are_sent_away_in_the_end(page: Page) -> None:
    with ExitStack() as stack:
        silent = [stack.enter_context(page.connect()) for _ in range(3)]
        wait_until("they are there", lambda: page.open == len(silent))
        wait_until("all of them are gone", lambda: page.open == 0)


@pytest.mark.wall
def test_those_who_are_served_are_not_sent_away_for_silent_ones(page: Page) -> None:
    with ExitStack() as stack:
        follower = stack.enter_context(page.connect())
        follower.sendall(ASK.replace(b"/ ", b"/events ", 1))
        assert follower.recv(100)
        for _ in range(2 * MOST_CONNECTIONS):
            stack.enter_context(page.connect())
        end = time.monotonic() + 2 * SHORT_S
        while time.monotonic() < end:
            assert follower.recv(1000)


@pytest.mark.wall
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

        wait_until("it is sent away", sent_away, timeout_s=5 * SHORT_S)


@pytest.mark.wall
@pytest.mark.parametrize("path", [b"/large ", b"/flood "])
def test_who_reads_nothing_is_dropped(page: Page, path: bytes) -> None:
    with page.connect(buffer=4096) as client:
        client.sendall(ASK.replace(b"/ ", path, 1))
        wait_until("it is served", lambda: page.open == 1)
        wait_until("it is dropped", lambda: page.open == 0, timeout_s=20 * SHORT_S)


@pytest.mark.wall
def test_a_large_answer_may_take_its_time_and_so_may_the_page(page: Page) -> None:
    with page.connect() as client:
        client.sendall(ASK.replace(b"/ ", b"/large ", 1))
        got, end = 0, time.monotonic() + 3 * SHORT_S
        while time.monotonic() < end:
            got += len(client.recv(200_000))
            time.sleep(0.02)
        while got < LARGE:
            piece = client.recv(1_000_000)
            assert piece, "sent away while it read"
            got += len(piece)
    assert page.answers("/slow")


# Commands of the page where the system gives no thread.


def test_a_stop_needs_no_new_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    link = ToolLink(load(profile_path()).with_socket(tmp_path / "socket"), cast(Any, None))
    monkeypatch.setattr(threading.Thread, "start", start)
    answer = asyncio.run(link.command("stop"))
    assert answer.reason.startswith("The stop is not latched: ")  # for there is no line arbiter


# The page's side of a testbench's socket, with a real testbench at the other one.


@pytest.fixture
def tool(verdin: Description) -> Description:
    return load(write_virtual_copy(verdin, Path(mkdtemp(prefix="eehal-faults-"))))


async def until(what: Callable[[], bool]) -> None:
    end = now_us() + round(PATIENCE_S * 1e6)
    while not what():
        assert now_us() < end
        await asyncio.sleep(0.02)


@pytest.mark.wall
def test_it_is_found_asked_lost_and_found_again(tool: Description) -> None:
    view = FaultsView(tool, ToolView(tool, now_us()).log)
    link = TestbenchLink(tool, view)
    commands = FaultCommands(link.ask, lambda: view.there)
    bench = Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None))

    async def play() -> None:
        following = asyncio.create_task(link.run())
        await asyncio.sleep(0.5)
        assert not view.there
        assert not view._log.entries, "a tool without a testbench is nothing to speak of"
        assert (await link.ask("choose", "no-tool")).reason == "There is no connection to the testbench."
        with ExitStack() as running:
            running.enter_context(bench)
            server = running.enter_context(FaultServer(tool, bench, lambda _: None))
            await until(lambda: view.there)
            refused = await commands.obey("arm", "one", "Page 1", "leek", now_us)
            assert refused.reason == "no fault is named 'leek'. Did you mean 'leak'?"
            assert (await commands.obey("arm", "one", "Page 1", "leak:top_vacuum", now_us)).accepted
            assert bench.scenario == "nominal"
            assert (await commands.obey("go", "one", "Page 1", "leak:top_vacuum", now_us)).accepted
            assert bench.scenario == "leak:top_vacuum"
            await until(lambda: (view.now(now_us()) or {}).get("scenario") == "leak:top_vacuum")
            await asyncio.to_thread(server.close)
            await until(lambda: not view.there)
            with FaultServer(tool, bench, lambda _: None):
                await until(lambda: view.there and view.version == 2)
                assert (await commands.obey("nominal", "one", "Page 1", "", now_us)).accepted
                assert bench.scenario == "nominal"
        await until(lambda: not view.there)
        following.cancel()

    asyncio.run(play())


@pytest.mark.wall
def test_a_testbench_of_another_description_is_not_shown(tool: Description) -> None:
    other = tool.model_copy(update={"summary": "another one"})
    view = FaultsView(other, ToolView(other, now_us()).log)
    bench = Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None))

    async def play() -> None:
        following = asyncio.create_task(TestbenchLink(other, view).run())
        await until(lambda: bool(view._log.entries))
        assert "simulates another description" in view._log.entries[0]["text"]
        assert not view.there
        following.cancel()

    with bench, FaultServer(tool, bench, lambda _: None):
        asyncio.run(play())
