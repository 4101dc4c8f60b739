"""A tool of another process: its records over a socket, when it is ready, and what is left without it."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.control import Answer, EventKind, Status, ToolEvent
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import NotReadyError, ReportedError
from end_effector_hal.runtime import EndEffector, RemoteTool
from end_effector_hal.runtime.boundary import STREAMED, Published
from end_effector_hal.runtime.boundary._open import header_of
from end_effector_hal.runtime.stream import ProgramCommand, program_socket
from end_effector_hal.runtime.tool._ready import is_ready, missing
from end_effector_hal.runtime.tool._remote_program import RemoteProgram
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.vocabulary import Alarm, EndEffectorState, Evidence
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.rpc import Reply, Server, record_line
from end_effector_hal.wires.rpc._messages import adapter_of
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.lone_program import Tool
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.virtual_tool import VirtualTool


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


# What a face in another process has of the HAL: records as they come over the socket, and what is left without it.


READINGS = JudgedReadings(5, {"bottom": -60_000, "locked": True, "top": None}, ("bottom", "locked"))
HEALTH = SensorHealth(
    {"": LinkHealth(state=LinkState.UP, since=3, frames=7, errors={"crc": 1}, faults=("Unit 2 is mute.",))},
    InputsHealth(since=4, edges=2),
)


@pytest.mark.parametrize(("kind", "content"), [("readings", READINGS), ("health", HEALTH)])
def test_a_record_survives_the_socket(kind: str, content: object) -> None:
    line = json.loads(record_line(kind, 5, content))
    back = adapter_of(STREAMED[kind]).validate_python(line["content"])
    assert back == content
    assert repr(back) == repr(content), "a bit stays a bit"


class Heard:
    """A program in another process; the test is the socket."""

    def __init__(self, description: Description) -> None:
        self.statuses: list[Status] = []
        self.readings: list[JudgedReadings] = []
        self.program = RemoteProgram(
            description, self.statuses.append, lambda _: None, self.readings.append, lambda: None
        )


@pytest.fixture
def heard(verdin: Description) -> Iterator[Heard]:
    made = Heard(verdin)
    yield made
    made.program.close()


def test_readings_and_health_are_known_until_the_hal_is_lost(heard: Heard) -> None:
    heard.program.take(READINGS)
    heard.program.take(HEALTH)
    assert heard.readings == [READINGS]
    assert heard.program.health == HEALTH
    heard.program._lose("The HAL is silent.")
    assert heard.program.health == SensorHealth({}, None)
    assert set(heard.readings[-1].values.values()) == {None}
    assert {"bottom", "locked"} <= set(heard.readings[-1].values)
    (lost,) = heard.statuses
    assert lost.ee is EndEffectorState.OFF
    assert lost.alarm("hal.lost")
    assert not heard.program.alive


def test_only_records_that_somebody_wants_are_read(heard: Heard) -> None:
    def send(kind: str, content: object) -> None:
        heard.program._receive(record_line(kind, 5, content).rstrip())

    send("readings", "what no reader could take")
    send("step", {})
    assert heard.readings == []
    heard.program.want("readings")
    send("readings", READINGS)
    assert heard.readings == [READINGS]
    with pytest.raises(ReportedError, match="A record of the HAL cannot be read"):
        send("readings", "what no reader could take")


# When a tool is ready: nothing that its sensors show has the next command refused.


GONE, PARTIAL, CONFIRMED, UNKNOWN = Evidence.GONE, Evidence.PARTIAL, Evidence.CONFIRMED, Evidence.UNKNOWN
STAND_BY, GRIP_ERROR, OFF = EndEffectorState.STAND_BY, EndEffectorState.GRIP_ERROR, EndEffectorState.OFF


@pytest.fixture(scope="module")
def tool() -> VirtualTool:
    tool = VirtualTool(load(profile_path()))
    tool.run(1.0)
    return tool


@pytest.mark.parametrize(
    ("state", "evidence", "ready"),
    [
        (STAND_BY, (GONE, GONE, GONE), True),
        (STAND_BY, (GONE, PARTIAL, GONE), False),
        (STAND_BY, (GONE, GONE, CONFIRMED), False),
        (STAND_BY, (GONE, UNKNOWN, GONE), False),
        (GRIP_ERROR, (CONFIRMED, PARTIAL, GONE), True),  # a Drop is accepted
        (GRIP_ERROR, (CONFIRMED, UNKNOWN, GONE), False),
        (OFF, (GONE, GONE, GONE), False),
    ],
)
def test_by_state_and_evidence(
    tool: VirtualTool, state: EndEffectorState, evidence: Sequence[Evidence], ready: bool
) -> None:
    status = replace(tool.status, ee=state, evidence=tuple(evidence))
    assert is_ready(tool.description, status) is ready
    assert not is_ready(tool.description, replace(status, link_up=False))


def test_without_il_07_feedback_is_not_in_the_way(tool: VirtualTool) -> None:
    locks = tool.description.interlocks.model_copy(update={"il_07": False})
    free: Description = tool.description.model_copy(update={"interlocks": locks})
    assert is_ready(free, replace(tool.status, evidence=(GONE, PARTIAL, GONE)))


def test_what_is_in_the_way_is_named(tool: VirtualTool) -> None:
    status = replace(tool.status, evidence=(PARTIAL, GONE, CONFIRMED))
    told = list(missing(tool.description, status, SensorHealth({}, None)))
    assert told == [
        "a grip would be refused, since Bottom vacuum, Top vacuum are not proven to be gone "
        "(IL-07): a Drop releases once more"
    ]


def test_a_tool_that_is_ready_grips_also_after_the_link_was_silent(tool: VirtualTool) -> None:
    """In every instant after the frames are back: ready means that the automata accept a grip."""
    played = VirtualTool(tool.description)
    played.play(1.0, "lock", 1.0)
    played.link = False
    played.run(0.4)
    played.link = True
    seen = set()
    for _ in range(40):
        played.run(0.01)
        ready = is_ready(played.description, played.status)
        if ready:
            assert played.controller.refusal("grip") == ""
        elif Evidence.UNKNOWN not in played.status.evidence:
            assert played.controller.refusal("grip").startswith("IL-07")
            seen.add("partial")
        seen.add(ready)
    assert seen == {False, "partial", True}


# The status that was published last is published again with a notice about a listener.


def test_a_notice_repeats_no_event_and_does_not_anticipate_what_is_published_next() -> None:
    """The program has gone on; its states are published in their order, not the last one first."""
    told: list[Status] = []
    began = ToolEvent(1_000, EventKind.STATE_CHANGED, old=0, new=6)
    standing = replace(Tool().program.status, at=1_000, ee=EndEffectorState.STAND_BY, events=(began,))
    gripping = replace(standing, at=2_000, ee=EndEffectorState.GRIPPING, events=())
    tool: Any = object.__new__(EndEffector)
    tool._lock, tool._latest = threading.Lock(), None
    tool._audience = SimpleNamespace(put=told.append, alarms=())
    tool._follow(SimpleNamespace(status=gripping))
    tool._moved(standing)
    tool._audience.alarms = (notice := Alarm("listener.failed", "hal", {"text": "it raised."}),)
    tool._audience_changed()
    tool._moved(gripping)
    assert [(each.ee.name, each.events) for each in told] == [
        ("STAND_BY", (began,)), ("STAND_BY", ()), ("GRIPPING", ()),
    ]  # fmt: skip
    assert [notice in each.alarms for each in told] == [False, True, True]
