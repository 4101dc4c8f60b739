"""Pressure on a transport and a tool of the test: what it publishes of the readings, and what it says of the links."""

from __future__ import annotations

from math import isnan
from typing import Any, cast

import pytest

from end_effector_hal.nodes._pressure import PressureNode
from end_effector_hal.nodes.interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires import now_us
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.lone_node import LoneTransport, status


@pytest.fixture
def transport() -> LoneTransport:
    transport = LoneTransport()
    PressureNode(cast("Any", transport))
    return transport


def health(transport: LoneTransport) -> Any:
    transport.ticks[DIAGNOSTICS_HZ]()
    (found,) = transport.published[DIAGNOSTICS.name][-1].status
    return found


def test_a_pressure_is_absolute_and_comes_with_each_frame_that_has_read_it(transport: LoneTransport) -> None:
    bottom, top = (transport.published[f"PressureVacuum{name}"] for name in ("Bottom", "Top"))
    transport.hal.reads(bottom=-60_000)
    transport.hal.reads(bottom=-60_000)
    transport.hal.reads("top", bottom=-60_000, top=0)
    assert [each.fluid_pressure for each in bottom] == [41_325.0] * 2, "another link has read the third frame"
    assert [each.fluid_pressure for each in top if not isnan(each.fluid_pressure)] == [101_325.0]
    assert bottom[0].header.frame_id == "verdin_gripper_link"


def test_a_pressure_that_is_not_known_is_published_once(transport: LoneTransport) -> None:
    bottom = transport.published["PressureVacuumBottom"]
    transport.hal.reads(bottom=0)
    for _ in range(3):
        transport.hal.reads("top", bottom=None, top=0)
    assert [isnan(each.fluid_pressure) for each in bottom] == [False, True]
    transport.hal.reads(bottom=0)
    assert len(bottom) == 3


def test_frames_are_skipped_while_no_pressure_is_read(transport: LoneTransport) -> None:
    (key,) = transport.hal.keys
    assert key is not None
    frames = [JudgedReadings(at, {}) for at in (1, 2, 3)]
    for topic in transport.published.values():
        topic.read = False
    assert len({key(frame) for frame in frames}) == 1
    transport.published["PressureVacuumTop"].read = True
    assert len({key(frame) for frame in frames}) == 3


def test_the_health_is_that_of_the_link_as_the_hal_has_sent_it(
    transport: LoneTransport, caplog: pytest.LogCaptureFixture
) -> None:
    transport.hal.says(status())
    assert "has not reported the state of its sensors" in health(transport).message
    up = LinkHealth(state=LinkState.UP, since=0, last_frame=now_us(), frames=7)
    transport.hal.sensors = SensorHealth({"": up}, None)
    with caplog.at_level("INFO"):
        assert (health(transport).level, health(transport).message) == (0, "The link is up.")
    assert [each.getMessage() for each in caplog.records] == ["the sensor link is up"]
    assert {each.key: each.value for each in health(transport).values}["frames"] == "7"
    transport.hal.says(status(alarms=(Alarm("stamps.refused", "Frames", {"why": "late", "doubt": "Why?"}),)))
    assert health(transport).level == 1
    transport.hal.says(status(link_up=False))
    assert health(transport).message.startswith("The port is open, but no frame comes (for ")
    lost = LinkHealth(state=LinkState.DOWN, since=0, error="It was pulled.")
    transport.hal.sensors = SensorHealth({"": lost}, None)
    assert (health(transport).level, health(transport).message) == (2, "It was pulled.")
    transport.hal.alive = False
    assert health(transport).message == "The HAL has not reported yet."
