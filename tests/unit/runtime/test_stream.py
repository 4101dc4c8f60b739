"""The stream of a program: what a reader gets, and that nobody can make the program wait."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.runtime.stream import MOST_WAITING, ProgramCommand, RecordStream
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import ClientLimits
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.patience import wait_until

pytestmark = pytest.mark.wall
LIMITS = ClientLimits()


def no_health() -> SensorHealth:
    return SensorHealth({}, None)


class Served:
    """A stream, and a program that does nothing but look whether a state is wanted."""

    def __init__(self, folder: Path) -> None:
        arbiter = folder / "a.sock"
        arbiter.touch()
        self.path = folder / "a.sock.hal"
        self.asked: list[str] = []
        self.works = True
        self.hold = threading.Event()
        self.hold.set()
        self.stream = RecordStream(self.path, arbiter, lambda at: {"run": "7"}, ("grip", "cancel"))
        self.stream.serve(self.command, lambda: self.works, self.nudge, no_health)
        self.state = 0

    def command(self, asked: ProgramCommand) -> Answer:
        self.hold.wait(10)
        self.asked.append(asked.command)
        self.until_us = asked.until_us
        return Answer(
            asked.command == "grip", "" if asked.command == "grip" else "There is nothing to cancel."
        )

    def nudge(self) -> None:
        self.state += 1
        self.stream.begin([("state", 0, {"number": self.state})])

    def reader(self) -> Reading:
        return Reading(self.path)


class Reading:
    def __init__(self, path: Path) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(10)
        self.sock.connect(str(path))
        self.file = self.sock.makefile("rb")

    def next(self, *, but: tuple[str, ...] = ("alive", "health")) -> dict[str, Any]:
        try:
            while (found := json.loads(self.file.readline() or b"null")) and found["kind"] in but:
                pass
        except ConnectionResetError:
            return {"kind": "end"}
        return found or {"kind": "end"}

    def ask(self, **message: object) -> dict[str, Any]:
        self.sock.sendall(json.dumps(message).encode() + b"\n")
        return self.next()

    def close(self) -> None:
        self.file.close()
        self.sock.close()


@pytest.fixture
def served() -> Iterator[Served]:
    # a socket's path may be 108 bytes long only
    made = Served(Path(mkdtemp(prefix="eehal-stream-")))
    yield made
    made.hold.set()
    made.stream.close()
    assert not made.path.exists()


def test_a_reader_begins_with_a_state_and_gets_every_record_from_there_on(served: Served) -> None:
    served.stream.put([("frame", 1, {"lost": True})])  # nobody reads
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["content"]] == ["header", {"number": 1}]
    served.stream.put([("frame", number, {"number": number}) for number in range(3)])
    assert [reader.next()["content"]["number"] for _ in range(3)] == [0, 1, 2]
    second = served.reader()
    assert [second.next()["kind"], second.next()["content"]] == ["header", {"number": 2}]
    served.stream.put([("frame", 9, {"number": 9})])
    assert reader.next()["content"] == second.next()["content"] == {"number": 9}
    reader.close()
    second.close()


def test_who_never_reads_is_dropped_and_the_program_never_waits(served: Served) -> None:
    """The program's side takes microseconds, whatever the readers do."""
    idle = [served.reader() for _ in range(3)]
    keeps_up = served.reader()
    assert keeps_up.next()["kind"] == "header"
    assert keeps_up.next()["kind"] == "state"
    got: list[int] = []
    thread = threading.Thread(target=_read_numbers, args=(keeps_up, got), daemon=True)
    thread.start()
    filler, longest = "x" * 2_000, 0.0
    count = 3 * LIMITS.backlog // 2_000
    for number in range(count):
        begun = time.perf_counter()
        served.stream.put([("frame", number, {"number": number, "filler": filler})])
        longest = max(longest, time.perf_counter() - begun)
        if number % 200 == 199:
            wait_until("the records are read", lambda last=number: got and got[-1] == last)
    assert longest < 0.05
    assert got == list(range(count))
    for each in idle:
        wait_until("it is dropped", lambda each=each: _is_dropped(each))
        each.close()
    keeps_up.sock.shutdown(socket.SHUT_RDWR)
    thread.join(10)
    keeps_up.close()


def _read_numbers(reader: Reading, got: list[int]) -> None:
    while (found := reader.next())["kind"] == "frame":
        got.append(found["content"]["number"])


def _is_dropped(reader: Reading) -> bool:
    reader.sock.setblocking(True)
    reader.sock.settimeout(5)
    try:
        while reader.sock.recv(1 << 20):
            pass
    except ConnectionResetError:
        return True
    return True


def test_records_that_were_lost_are_followed_by_a_new_state(served: Served) -> None:
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
    served.stream.put([("frame", number, {}) for number in range(MOST_WAITING + 2)])  # more than may wait
    found = reader.next()
    while found["kind"] == "frame":
        found = reader.next()
    assert [found["kind"], reader.next()["content"]] == ["header", {"number": 2}]
    reader.close()


def test_a_command_is_answered_and_one_that_is_late_or_unknown_is_not_executed(served: Served) -> None:
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
    soon = now_us() + 1_000_000
    assert reader.ask(id=1, command="grip", until_us=soon)["accepted"]
    assert served.until_us == soon  # the program looks once more, when it decides
    refused = reader.ask(id=2, command="cancel", until_us=soon)
    assert (refused["id"], refused["reason"]) == (2, "There is nothing to cancel.")
    assert "too late" in reader.ask(id=3, command="grip", until_us=now_us() - 1)["reason"]
    assert "Check the clock" in reader.ask(id=4, command="grip", until_us=now_us() + 60_000_000)["reason"]
    assert "no such command" in reader.ask(id=5, command="fly", until_us=soon)["reason"]
    for malformed in ({}, {"id": "1", "command": "grip", "until_us": soon}, {"id": 1, "command": ["grip"]}):
        assert "This is not a valid request: " in reader.ask(**malformed)["reason"]
    assert served.asked == ["grip", "cancel"]
    reader.close()


def test_commands_that_wait_are_bounded_and_a_command_that_waited_too_long_is_not_executed(
    served: Served,
) -> None:
    served.hold.clear()
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
    until = now_us() + 300_000
    for number in range(8):
        message = {"id": number, "command": "grip", "until_us": until}
        reader.sock.sendall(json.dumps(message).encode() + b"\n")
    answers = [reader.next() for _ in range(4)]
    assert {answer["reason"] for answer in answers} == {
        "Too many requests are waiting: this one is not executed."
    }
    wait_until("their time is over", lambda: now_us() > until)
    served.hold.set()
    rest = [reader.next() for _ in range(4)]
    assert [answer["accepted"] for answer in rest] == [True, False, False, False]
    assert served.asked == ["grip"]
    reader.close()


def test_commands_of_those_who_have_gone_do_not_pile_up(served: Served) -> None:
    served.hold.clear()
    until = now_us() + 1_900_000
    message = json.dumps({"id": 1, "command": "grip", "until_us": until}).encode() + b"\n"
    for _ in range(LIMITS.all_requests // LIMITS.requests + 1):
        reader = served.reader()
        assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
        reader.sock.sendall(message * (LIMITS.requests + 1))
        assert "Too many requests are waiting" in reader.next()["reason"], "all of them were read"
        reader.close()
    last = served.reader()
    assert [last.next()["kind"], last.next()["kind"]] == ["header", "state"]
    assert "Too many requests are waiting" in last.ask(id=2, command="cancel", until_us=until)["reason"]
    served.hold.set()
    wait_until("they are decided", lambda: len(served.asked) == LIMITS.all_requests + 1)
    assert last.ask(id=3, command="grip", until_us=now_us() + 1_000_000)["accepted"]
    last.close()


@pytest.mark.parametrize("message", [b"[]\n", b'{"id": 1, "command": "fly", "until_us": 1}\n'])
def test_a_flood_of_messages_ends_its_connection_only(served: Served, message: bytes) -> None:
    reader, other = served.reader(), served.reader()
    reader.sock.sendall(message * (9000 // len(message)))
    found = [reader.next()]
    while found[-1]["kind"] != "end":
        found.append(reader.next())
    assert "messages came within a second" in found[-2].get("reason", "")
    assert len(found) <= 2 * LIMITS.rate
    assert [other.next()["kind"], other.next()["kind"]] == ["header", "state"]
    assert other.ask(id=1, command="grip", until_us=now_us() + 1_000_000)["accepted"]
    reader.close()
    other.close()


def test_the_health_of_the_links_comes_at_once_and_not_from_a_program_that_hangs(served: Served) -> None:
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
    first = reader.next(but=("alive",))
    assert (first["kind"], first["content"]) == ("health", {"links": {}, "inputs": None})
    assert reader.next(but=("alive",))["kind"] == "health"
    served.works = False
    reader.sock.settimeout(1.5)
    with pytest.raises(TimeoutError):
        reader.next(but=("alive",))
    reader.close()


def test_there_is_a_sign_of_life_only_while_the_program_works(served: Served) -> None:
    reader = served.reader()
    assert [reader.next()["kind"], reader.next()["kind"]] == ["header", "state"]
    assert reader.next(but=("health",))["kind"] == "alive"
    served.works = False
    reader.sock.settimeout(1.5)
    with pytest.raises(TimeoutError):
        reader.next()  # whatever was on its way is passed over
    reader.close()


def test_there_is_room_for_so_many_readers_and_an_overlong_message_ends_one(served: Served) -> None:
    readers = [served.reader() for _ in range(LIMITS.clients)]
    for each in readers:
        assert each.next()["kind"] == "header"
    surplus = served.reader()
    assert surplus.next()["kind"] == "end"
    readers[0].sock.sendall(b"x" * 10_000)
    while readers[0].next()["kind"] != "end":
        pass
    for each in (*readers, surplus):
        each.close()


def test_one_who_does_not_read_loses_his_place_to_one_who_comes(served: Served) -> None:
    silent = [served.reader() for _ in range(LIMITS.clients - 1)]
    reads = served.reader()
    assert [reads.next()["kind"], reads.next()["kind"]] == ["header", "state"]
    for number in range(12):  # more than the system keeps for a reader, less than the stream does
        served.stream.put([("frame", number, {"values": "x" * 1000})] * 50)
        for _ in range(50):
            assert reads.next()["at"] == number
    newcomers = [served.reader() for _ in silent]
    for each in newcomers:
        assert each.next()["kind"] == "header"
    served.stream.put([("frame", 12, {})])
    assert reads.next()["at"] == 12
    surplus = served.reader()
    assert surplus.next()["kind"] == "end"
    for each in (*silent, *newcomers, reads, surplus):
        each.close()


def test_the_socket_has_the_rights_of_the_line_arbiter(served: Served) -> None:
    found = served.path.stat()
    assert found.st_mode & 0o777 == 0o660
    assert found.st_gid == (served.path.parent / "a.sock").stat().st_gid


def test_a_socket_that_cannot_be_made_is_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    nowhere = Path("/nowhere/a.sock")
    stream = RecordStream(nowhere.with_name("a.sock.hal"), nowhere, lambda at: {}, ("grip",))
    stream.serve(lambda word: Answer(True), lambda: True, lambda: None, no_health)
    stream.put([("frame", 0, {})])
    stream.close()
    assert "the live page cannot show this program" in caplog.text
