"""A tool of another process, at a HAL that sends what a test wants."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import NotReadyError
from end_effector_hal.runtime import EndEffector, RemoteTool
from end_effector_hal.runtime.boundary import Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import ProgramCommand, program_socket
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import Reply, Server, record_line
from tests.support.lone_program import Tool
from tests.support.patience import PATIENCE_S, wait_until


class Hal:
    """A HAL that sends one status to each client, and accepts every command once ``answers`` is set."""

    def __init__(self, description: Description) -> None:
        self.answers, self.asked = threading.Event(), 0
        self.answers.set()
        self.content: dict[str, Any] = {}
        self.description = description
        self.server = Server(
            program_socket(description), greets=True, request=ProgramCommand, handle=self._handle
        )
        self.server.start("hal", self._turn)

    def _turn(self) -> float:
        self.server.send(record_line("alive", now_us(), {}))
        if self.server.has_newcomers:
            header = record_line("header", now_us(), header_of(self.description, now_us()))
            status = replace(Tool().program.status, count=1, begun=7, **self.content)
            self.server.begin(header + record_line("published", now_us(), Published(now_us(), status, {})))
        return 0.05

    def _handle(self, _: ProgramCommand) -> Reply:
        self.asked += 1
        self.answers.wait(PATIENCE_S)
        return Reply(True, record=1)


@pytest.fixture
def hal() -> Iterator[Hal]:
    folder = Path(mkdtemp(prefix="eehal-remote-"))
    tool = load(profile_path())
    made = Hal(tool.with_virtual(folder / "chip", str(folder / "uart"), folder / "socket"))
    yield made
    made.answers.set()
    made.server.close()


@pytest.fixture
def face(hal: Hal) -> Iterator[RemoteTool]:
    with EndEffector.connect(hal.description, timeout_s=PATIENCE_S) as tool:
        yield tool


@pytest.mark.wall
def test_several_hundred_commands_in_a_row_all_reach_the_hal(face: RemoteTool, hal: Hal) -> None:
    answers = [face.arm() for _ in range(250)]
    assert all(answer.accepted for answer in answers), [each.reason for each in answers if not each.accepted]
    assert hal.asked == 250


@pytest.mark.wall
def test_the_end_of_a_connection_ends_a_request_at_once(face: RemoteTool, hal: Hal) -> None:
    hal.answers.clear()
    found: list[tuple[float, Answer]] = []

    def ask() -> None:
        begun = time.monotonic()
        answer = face.arm()
        found.append((time.monotonic() - begun, answer))

    asking = threading.Thread(target=ask)
    asking.start()
    wait_until("the request", lambda: hal.asked == 1)
    face.close()
    asking.join(PATIENCE_S)
    ((seconds, answer),) = found
    assert not answer.decided
    assert answer.reason == "The HAL has gone: it is unknown whether the command was executed."
    assert seconds < 3.0


@pytest.mark.wall
def test_a_closed_tool_is_not_alive(face: RemoteTool) -> None:
    assert face.alive
    face.close()
    assert not face.alive


@pytest.mark.wall
@pytest.mark.parametrize(
    "content",
    [{"actuators": (0,)}, {"outputs": ()}, {"evidence": ()}, {"actuators": (99, 0, 0)}],
    ids=["actuators", "outputs", "evidence", "state"],
)
def test_a_status_that_does_not_fit_the_tool_is_not_shown(hal: Hal, content: dict[str, Any]) -> None:
    hal.content = content
    with pytest.raises(NotReadyError, match="A record of the HAL cannot be read"):
        EndEffector.connect(hal.description, timeout_s=1.0)
