"""What a face in another process has of the HAL: records as they come over the socket, and what is left without it."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime.boundary import STREAMED
from end_effector_hal.runtime.tool._remote_program import RemoteProgram
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.rpc import record_line
from end_effector_hal.wires.rpc._messages import adapter_of
from end_effector_hal.wires.sensors import SensorHealth

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
