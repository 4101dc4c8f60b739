"""The client in an asyncio loop: it comes back by itself, and every failure is a sentence."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.wires.rpc import ClientLimits, Reply, RpcRequest, Server, aio, record_line
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.wall


@dataclass(frozen=True, slots=True)
class Number:
    number: int


@dataclass(frozen=True, slots=True)
class Question(RpcRequest):
    word: str


class Following:
    """A client that keeps what it gets."""

    def __init__(self, path: Path) -> None:
        self.records: list[tuple[str, int, Any]] = []
        self.lost: list[str] = []
        self.client = aio.AsyncClient(
            path,
            "The program",
            {"number": Number},
            lambda *record: self.records.append(record),
            self.lost.append,
        )

    async def until(self, ready: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not ready():
                await asyncio.sleep(0.01)

    async def connected(self) -> None:
        await self.until(lambda: self.client._writer)


def played(path: Path, play: Callable[[Following], Awaitable[None]]) -> None:
    async def run() -> None:
        following = Following(path)
        task = asyncio.create_task(following.client.run())
        await play(following)
        task.cancel()

    asyncio.run(run())


def serving(path: Path, handle: Callable[[Question], Reply] = lambda _: Reply(True)) -> Server:
    server = Server(path, ClientLimits(line=200), request=Question, handle=handle)
    server.start("served", lambda: None)
    return server


def test_it_is_found_asked_lost_and_found_again(tmp_path: Path) -> None:
    path = tmp_path / "socket"

    async def play(following: Following) -> None:
        await following.until(lambda: following.lost)
        assert following.lost[0] == f"The program does not run, or has no socket ({path})."
        unsent = await following.client.request(word="x")
        assert unsent == Reply(False, "There is no connection to the program.")
        for _ in range(2):
            server, before = serving(path, lambda asked: Reply(False, asked.word)), len(following.lost)
            await following.connected()
            replies = await asyncio.gather(*(following.client.request(word=f"w{n}") for n in range(3)))
            assert replies == [Reply(False, f"w{n}") for n in range(3)]
            await asyncio.to_thread(server.close)
            await following.until(lambda before=before: len(following.lost) > before)
            assert following.lost[before] == "The program has ended its connection."

    played(path, play)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"noise\n", "A record of the program cannot be read: "),
        (b"[]\n", "A record of the program cannot be read: "),
        (b'{"kind": "answer-to", "id": []}\n', "A record of the program cannot be read: "),
        (record_line("number", 5, {"number": "seven"}), "A record of the program cannot be read: "),
        (b"x" * 4_100_000, "A record of the program cannot be read: "),
    ],
    ids=["noise", "list", "answer", "content", "endless"],
)
def test_what_is_no_record_ends_the_connection_and_it_connects_again(
    tmp_path: Path, line: bytes, why: str
) -> None:
    to_send = [record_line("alive", 1, {}), record_line("number", 2, {"number": 7}), line]
    server = Server(tmp_path / "socket", ClientLimits(backlog=9_000_000))

    def turn() -> float:
        if len(server):
            server.send(b"".join(to_send))
            to_send.clear()
        return 0.01

    server.start("served", turn)

    async def play(following: Following) -> None:
        await following.until(lambda: following.lost)
        assert following.records == [("alive", 1, None), ("number", 2, Number(7))]
        assert following.lost[0].startswith(why)

        def comes() -> bool:
            to_send.append(
                record_line("number", 3, {"number": 8})
            )  # again: the old connection may be seen to end late
            return len(following.records) > 2

        await following.until(comes)

    with closing(server):
        played(tmp_path / "socket", play)


def test_a_server_that_does_not_answer_or_goes_leaves_the_request_undecided(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(aio, "ANSWER_S", 0.2)
    server = Server(tmp_path / "socket")
    server.start("served", lambda: None)

    async def play(following: Following) -> None:
        await following.connected()
        silent = await following.client.request(word="x")
        unknown = "it is unknown whether the command was executed."
        assert silent == Reply(False, f"The program does not answer: {unknown}", decided=False)
        monkeypatch.setattr(aio, "ANSWER_S", PATIENCE_S)
        asked = asyncio.create_task(following.client.request(word="x"))
        await asyncio.sleep(0.05)
        await asyncio.to_thread(server.close)
        assert await asked == Reply(False, f"The program has gone: {unknown}", decided=False)

    with closing(server):
        played(tmp_path / "socket", play)
