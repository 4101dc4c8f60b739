"""The socket of a testbench: what it says of itself, what it refuses, and that nobody disturbs it."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from end_effector_hal.description import load
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import LONGEST
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import ClientLimits
from end_effector_hal.wires.rpc._messages import VALID_US
from end_effector_lab.testbench import Testbench, open_inputs, open_ports, write_virtual_copy
from end_effector_lab.testbench._faults import FaultServer
from tests.support.patience import wait_until

pytestmark = pytest.mark.wall


class Served:
    """A testbench on a virtual chip, with its socket."""

    def __init__(self, verdin: Any) -> None:
        # a socket's path may be 108 bytes long only
        self.folder = Path(mkdtemp(prefix="eehal-faults-"))
        self.tool = load(write_virtual_copy(verdin, self.folder))
        self.path = self.folder / "arbiter.sock.testbench"
        self.bench = Testbench(self.tool, open_inputs(None, self.tool), open_ports(None, self.tool, None))
        self.chosen: list[str] = []
        self.server = FaultServer(self.tool, self.bench, self.chosen.append)


class Page:
    """What a page does with the socket."""

    def __init__(self, path: Path) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(10)
        self.sock.connect(str(path))
        self.file = self.sock.makefile("rb")
        self.header = self.next() if path.exists() else {}

    def next(self) -> dict[str, Any]:
        try:
            found: dict[str, Any] = json.loads(self.file.readline() or b'{"kind": "end"}')
        except ConnectionResetError:
            return {"kind": "end"}
        return found

    def until(self, kind: str) -> dict[str, Any]:
        while (found := self.next())["kind"] != kind:
            assert found["kind"] != "end"
        return found

    def ask(self, **changed: object) -> tuple[bool, str]:
        message = {"id": 7, "word": "choose", "until_us": now_us() + VALID_US // 2, **changed}
        self.sock.sendall(json.dumps(message).encode() + b"\n")
        answer = self.until("answer-to")
        return answer["accepted"], answer["reason"]

    def close(self) -> None:
        self.file.close()
        self.sock.close()


@pytest.fixture
def served(verdin: Any) -> Iterator[Served]:
    made = Served(verdin)
    with made.bench, made.server:
        yield made
    assert not made.path.exists()


@pytest.fixture
def page(served: Served) -> Iterator[Page]:
    opened = Page(served.path)
    yield opened
    opened.close()


def test_it_says_what_is_wrong_and_what_could_be(served: Served, page: Page) -> None:
    assert page.header["kind"] == "header"
    assert page.header["content"]["tool"] == "verdin_gripper"
    assert "never-confirms" in [fault["name"] for fault in page.header["content"]["faults"]]
    assert page.next()["content"] == {"scenario": "nominal"}
    assert page.next()["content"] == {"scenario": "nominal"}, "a sign of life"
    assert oct(served.path.stat().st_mode & 0o777) == "0o660"
    assert served.path.stat().st_gid == os.getgid()
    served.bench.choose("no-tool")  # by its standard input
    second = Page(served.path)
    for each in (page, second):
        while (said := each.until("scenario")["content"]["scenario"]) == "nominal":
            pass
        assert said == "no-tool"
    second.close()


def test_a_scenario_is_checked_and_chosen(served: Served, page: Page) -> None:
    assert page.ask(word="check", scenario="leak:top_vacuum:4") == (True, "")
    assert (served.bench.scenario, served.chosen) == ("nominal", [])
    assert page.ask(scenario="leak:top_vacuum:4,no-tool") == (True, "")
    assert served.bench.scenario == "leak:top_vacuum:4,no-tool"
    assert served.chosen == ["leak:top_vacuum:4,no-tool"]


@pytest.mark.parametrize("word", ["check", "choose"])
@pytest.mark.parametrize(
    "text",
    ["", "leek:top_vacuum", "leak:cylinder", "lost-after:top_vacuum", "leak:top_vacuum:1e999", "noise:nan"],
)
def test_a_bad_scenario_is_refused_with_the_sentence_of_the_testbench(
    served: Served, page: Page, word: str, text: str
) -> None:
    with pytest.raises(UsageError) as refused:
        served.bench.check(text)
    assert page.ask(word=word, scenario=text) == (False, str(refused.value))
    assert (served.bench.scenario, served.chosen) == ("nominal", [])


def test_what_cannot_be_printed_or_came_too_late_changes_nothing(served: Served, page: Page) -> None:
    accepted, reason = page.ask(scenario="nominal,\nno-tool")
    assert (accepted, "cannot be printed" in reason) == (False, True)
    accepted, reason = page.ask(scenario="no-tool", until_us=now_us() - 1)
    assert (accepted, reason) == (False, "The request came too late and was not executed.")
    accepted, reason = page.ask(scenario="no-tool", until_us=now_us() + 10 * VALID_US)
    assert (accepted, "Check the clock" in reason) == (False, True)
    assert served.bench.scenario == "nominal"


def test_what_is_no_request_gets_a_sentence_and_the_connection_goes_on(served: Served, page: Page) -> None:
    for wrong in (b"scenario no-tool", b"\xff", b"{}", b'{"id": 1, "word": "quit"}'):
        page.sock.sendall(wrong + b"\n")
        answer = page.until("answer-to")
        assert (answer["id"], answer["accepted"]) == (None, False)
        assert answer["reason"].startswith("This is not a valid request: ")
    assert page.ask(scenario="no-tool") == (True, "")


def test_too_many_at_once_are_refused(served: Served, page: Page) -> None:
    request = {"id": 1, "word": "choose", "scenario": "nominal", "until_us": now_us() + VALID_US}
    page.sock.sendall(b"".join(json.dumps({**request, "id": n}).encode() + b"\n" for n in range(10)))
    answers = {each["id"]: each for each in (page.until("answer-to") for _ in range(10))}
    assert [answers[number]["accepted"] for number in range(10)] == [True] * 4 + [False] * 6
    assert answers[9]["reason"].startswith("Too many requests are waiting")


def test_an_overlong_message_ends_its_connection_only(served: Served, page: Page) -> None:
    flood = Page(served.path)
    flood.sock.sendall(b"x" * (LONGEST + 1))
    while flood.next()["kind"] != "end":
        pass
    flood.close()
    assert page.ask(scenario="no-tool") == (True, "")


def test_one_reader_too_many_is_turned_away(served: Served, page: Page) -> None:
    others = [Page(served.path) for _ in range(ClientLimits().clients - 1)]
    assert all(each.header["kind"] == "header" for each in others)
    refused = Page(served.path)
    assert refused.header["kind"] == "end"
    others[0].close()
    refused.close()

    def comes_in() -> bool:
        again = Page(served.path)
        again.close()
        return again.header["kind"] == "header"

    wait_until("there is room again", comes_in)
    for each in others[1:]:
        each.close()


def test_without_a_socket_the_testbench_goes_on(verdin: Any, caplog: pytest.LogCaptureFixture) -> None:
    made = Served(verdin)
    (made.folder / "file").touch()
    nowhere = made.tool.with_socket(made.folder / "file" / "arbiter.sock")
    with made.bench, FaultServer(nowhere, made.bench, made.chosen.append):
        made.bench.choose("no-tool")
    assert "no page can choose faults: " in caplog.text


def test_the_socket_of_one_who_came_after_is_left(verdin: Any) -> None:
    made = Served(verdin)
    with made.bench, made.server:
        made.path.unlink()
        made.path.touch()
    assert made.path.exists()
