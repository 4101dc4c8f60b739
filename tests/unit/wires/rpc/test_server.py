"""A server whose clients are slow, loud, dead or no clients at all: the others are served, and nobody waits."""

from __future__ import annotations

import json
import os
import select
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from random import Random
from tempfile import mkdtemp
from typing import Any

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import ClientLimits, Reply, RpcRequest, Server, record_line
from tests.support.nightly import examples
from tests.support.patience import wait_until

pytestmark = pytest.mark.wall
SMALL = ClientLimits(clients=3, line=200, backlog=300_000, rate=20, requests=2, all_requests=5)


@dataclass(frozen=True, slots=True)
class Greeting(RpcRequest):
    name: str


class Served:
    """A server that greets, in a thread; its requests can be held up."""

    def __init__(self, path: Path) -> None:
        self.path, self.done = path, list[str]()
        self.goes_on = threading.Event()
        self.goes_on.set()
        self.to_send: list[bytes] = []
        self.fails = False
        self.server = Server(path, SMALL, request=Greeting, handle=self.handle)
        self.server.start("served", self.turn)

    def turn(self) -> None:
        if self.fails:
            self.fails = False
            raise KeyError("a bug")
        while self.to_send:
            self.server.send(self.to_send.pop(0))

    def send(self, data: bytes) -> None:
        self.to_send.append(data)
        self.server.wake()

    def handle(self, asked: Greeting) -> Reply:
        self.goes_on.wait(10)
        if asked.name == "bug":
            raise KeyError(asked.name)
        if asked.name == "nobody":
            raise UsageError("There is nobody.")
        self.done.append(asked.name)
        return Reply(True, f"Hello, {asked.name}.")


class Far:
    """The other end of a connection."""

    def __init__(self, path: Path) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(10)
        self.sock.connect(str(path))
        self.file = self.sock.makefile("rb")

    def next(self) -> dict[str, Any]:
        try:
            found: dict[str, Any] = json.loads(self.file.readline() or b'{"kind": "end"}')
        except ConnectionResetError:
            return {"kind": "end"}
        return found

    def ask(self, name: str, number: int = 1, valid_us: int = 1_900_000) -> None:
        request = {"id": number, "name": name, "until_us": now_us() + valid_us}
        self.sock.sendall(json.dumps(request).encode() + b"\n")

    def hears(self, name: str) -> str:
        self.ask(name)
        return str(self.next().get("reason", "end"))

    def is_ended(self) -> bool:
        while (found := self.next())["kind"] != "end":
            assert found["kind"] in ("answer-to", "record")
        return True

    def close(self) -> None:
        self.file.close()
        self.sock.close()


@pytest.fixture
def served() -> Iterator[Served]:
    # a socket's path may be 108 bytes long only
    made = Served(Path(mkdtemp(prefix="eehal-rpc-")) / "socket")
    yield made
    made.goes_on.set()
    made.server.close()
    assert not made.path.exists()
    assert not [each.name for each in threading.enumerate() if each.name.startswith("served")]


@pytest.fixture
def far(served: Served) -> Iterator[Far]:
    made = Far(served.path)
    yield made
    made.close()


def test_a_request_is_answered_with_its_number(served: Served, far: Far) -> None:
    far.ask("Ada", 7)
    answer = {"accepted": True, "reason": "Hello, Ada.", "decided": True, "record": 0}
    assert far.next() == {"kind": "answer-to", "id": 7, **answer}
    assert far.hears("nobody") == "There is nobody."
    assert far.hears("bug") == "The request failed; the log has the reason."
    assert far.hears("Ada") == "Hello, Ada."


def test_a_request_that_is_late_is_not_executed(served: Served, far: Far) -> None:
    far.ask("Ada", valid_us=-1)
    assert far.next()["reason"] == "The request came too late and was not executed."
    far.ask("Ada", valid_us=60_000_000)
    assert "until_us is more than 2 s ahead. Check the clock." in far.next()["reason"]
    served.goes_on.clear()
    far.ask("Ada", 1)
    wait_until("it is executed", lambda: served.server._requests.empty())
    far.ask("Eve", 2, valid_us=10_000)
    time.sleep(0.05)
    served.goes_on.set()
    assert [far.next()["accepted"], far.next()["accepted"]] == [True, False]
    assert served.done == ["Ada"]


@pytest.mark.parametrize(
    "line", [b"", b"[]", b"\xff\xfe", b"{" * 150, b"{}", b'{"id": 1, "name": 7, "until_us": 1}', b"null"]
)
def test_a_line_that_is_no_request_gets_a_sentence(served: Served, far: Far, line: bytes) -> None:
    far.sock.sendall(line + b"\n")
    answer = far.next()
    assert (answer["id"], answer["accepted"]) == (None, False)
    assert answer["reason"].startswith("This is not a valid request: ")
    assert far.hears("Ada") == "Hello, Ada."


def test_a_line_may_come_in_pieces(served: Served, far: Far) -> None:
    line = json.dumps({"id": 1, "name": "Ada", "until_us": now_us() + 1_900_000}).encode() + b"\n"
    for piece in (line[:1], line[1:20], line[20:-1], line[-1:]):
        far.sock.sendall(piece)
        time.sleep(0.001)
    assert far.next()["reason"] == "Hello, Ada."


@pytest.mark.parametrize("noise", [b"x" * 201, b"x" * 100_000, bytes(range(11, 256)) * 40])
def test_a_line_without_an_end_ends_its_connection_only(served: Served, far: Far, noise: bytes) -> None:
    loud = Far(served.path)
    with suppress(OSError):  # it may be ended while it sends
        loud.sock.sendall(noise)
    assert loud.is_ended()
    loud.close()
    assert far.hears("Ada") == "Hello, Ada."


def test_too_many_lines_in_a_second_end_their_connection_only(served: Served, far: Far) -> None:
    loud = Far(served.path)
    loud.sock.sendall(b"[]\n" * 60)
    found = [loud.next()]
    while found[-1]["kind"] != "end":
        found.append(loud.next())
    assert found[-2]["reason"] == "More than 20 messages came within a second."
    assert len(found) == 22
    loud.close()
    assert far.hears("Ada") == "Hello, Ada."


def test_requests_that_wait_are_bounded_for_one_client_and_for_all(served: Served, far: Far) -> None:
    served.goes_on.clear()
    for number in range(4):
        far.ask("Ada", number)
    assert [far.next()["id"], far.next()["id"]] == [2, 3]
    for _ in range(2):  # of clients that have gone meanwhile
        gone = Far(served.path)
        for number in range(3):
            gone.ask("Eve", number)
        assert "Too many requests are waiting" in gone.next()["reason"]
        gone.close()
    last = Far(served.path)
    assert "Too many requests are waiting" in last.hears("Bob")
    served.goes_on.set()
    assert {far.next()["id"], far.next()["id"]} == {0, 1}
    assert last.hears("Bob") == "Hello, Bob."
    last.close()


def test_a_slow_reader_is_dropped_and_the_others_get_everything(
    served: Served, far: Far, caplog: pytest.LogCaptureFixture
) -> None:
    """The log has one line, however often slow readers come again."""
    assert far.hears("Ada") == "Hello, Ada."
    for _ in range(2):
        slow = Far(served.path)
        assert slow.hears("Ada") == "Hello, Ada."
        for number in range(60):
            served.send(record_line("record", number, "x" * 20_000))
            assert far.next()["at"] == number
        assert slow.is_ended()
        slow.close()
    assert [each.message for each in caplog.records] == [
        f"a client of {served.path} reads too slowly: it was disconnected"
    ]


def test_a_client_that_goes_is_not_reported(
    served: Served, far: Far, caplog: pytest.LogCaptureFixture
) -> None:
    assert far.hears("Ada") == "Hello, Ada."
    for number in range(10):
        gone = Far(served.path)
        gone.sock.sendall(b'{"a": "half')
        gone.close()
        served.send(record_line("record", number, "x" * 20_000))
        assert far.next()["at"] == number
    assert caplog.records == []


def test_a_client_that_is_only_slow_gets_everything(served: Served, far: Far) -> None:
    assert far.hears("Ada") == "Hello, Ada."
    for number in range(20):  # more than the system keeps for it, less than the limit
        served.send(record_line("record", number, "x" * 20_000))
    wait_until("all are sent", lambda: not served.to_send)
    assert [far.next()["at"] for _ in range(20)] == list(range(20))


def test_one_too_many_is_turned_away_unless_another_is_behind(served: Served, far: Far) -> None:
    others = [Far(served.path) for _ in range(2)]
    assert [each.hears("Ada") for each in (far, *others)] == ["Hello, Ada."] * 3
    surplus = Far(served.path)
    assert surplus.next()["kind"] == "end"
    for number in range(20):
        served.send(record_line("record", number, "x" * 20_000))
        assert far.next()["at"] == others[0].next()["at"] == number
    newcomer = Far(served.path)
    assert newcomer.hears("Ada") == "Hello, Ada."
    assert others[1].is_ended()
    for each in (*others, surplus, newcomer):
        each.close()


def test_a_dead_client_is_forgotten(served: Served, far: Far) -> None:
    for _ in range(10):
        dead = Far(served.path)
        dead.ask("Ada")
        dead.sock.shutdown(socket.SHUT_RD)
        dead.close()
    wait_until("there is one", lambda: len(served.server) == 1)
    assert far.hears("Ada") == "Hello, Ada."


def test_a_bug_does_not_end_the_server(served: Served, far: Far, caplog: pytest.LogCaptureFixture) -> None:
    served.fails = True
    served.server.wake()
    wait_until("it has failed", lambda: not served.fails)
    assert far.hears("Ada") == "Hello, Ada."
    assert [each.message for each in caplog.records] == [
        f"the socket {served.path} is not served for a moment"
    ]


def test_a_newcomer_gets_no_record_before_its_beginning(tmp_path: Path) -> None:
    server = Server(tmp_path / "socket", greets=True)
    first, second = Far(tmp_path / "socket"), None
    server.poll()
    server.send(b"1\n")
    assert server.has_newcomers
    server.begin(b"2\n")
    server.send(b"3\n")
    second = Far(tmp_path / "socket")
    server.poll()
    server.begin(b"4\n")
    server.lose_all()
    server.send(b"5\n")
    server.begin(b"6\n")
    server.close()
    assert first.file.read() == b"2\n3\n6\n"
    assert second.file.read() == b"4\n6\n"
    first.close()
    second.close()


def test_another_loop_waits_for_its_descriptor(tmp_path: Path) -> None:
    server = Server(tmp_path / "socket", ClientLimits(backlog=0))

    def is_readable() -> bool:
        return bool(select.select([server], [], [], 0)[0])

    assert not is_readable()
    server.wake()
    assert is_readable()
    server.poll()
    assert not is_readable()
    far = Far(tmp_path / "socket")
    assert is_readable()
    server.poll()
    server.send(b"x" * 10_000_000)  # no backlog: what cannot be sent at once ends the connection
    assert len(server) == 0
    far.close()
    server.close()


def test_the_socket_belongs_to_its_group_and_is_removed(served: Served) -> None:
    found = served.path.stat()
    assert found.st_mode & 0o777 == 0o660
    assert found.st_gid == os.getgid()


def test_whatever_comes_the_server_goes_on(served: Served, far: Far) -> None:
    """Binary noise, halves of requests, ends in the middle, from a seed each."""
    for seed in range(examples(40, 2_000)):
        random = Random(seed)
        others = [Far(served.path) for _ in range(2)]
        for _ in range(8):
            other = random.choice(others)
            try:
                match random.randrange(4):
                    case 0:
                        other.sock.sendall(random.randbytes(random.randrange(400)))
                    case 1:
                        other.ask("Eve", random.randrange(3), random.randrange(-9, 9_000_000))
                    case 2:
                        line = json.dumps({"id": 1, "name": "Eve", "until_us": now_us() + 9_000}).encode()
                        other.sock.sendall(line[: random.randrange(len(line))])
                    case 3:
                        other.sock.sendall(b"\n" * random.randrange(30))
            except OSError:
                pass  # it was ended
        for other in others:
            other.close()
        wait_until("they are forgotten", lambda: len(served.server) == 1)
        if seed % 10 == 0:
            time.sleep(0.05)  # a second has 20 messages
            assert far.hears("Ada") == "Hello, Ada."
