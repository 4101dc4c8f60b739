"""What ``/diagnostics`` says of a node."""

from __future__ import annotations

from typing import Any, cast

from end_effector_hal.nodes.interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.nodes.report import ERROR, OK, WARN, Health, level_of, publish_health
from end_effector_hal.vocabulary import LEAK, Alarm, EndEffectorState
from tests.support.lone_node import LoneTransport, status


def test_each_status_names_its_tool_and_its_hardware() -> None:
    for hardware in ("", "/dev/ttyUSB0"):
        node = LoneTransport()
        node.name = "left/Pressure"
        publish_health(
            cast("Any", node), "left_tool", lambda: Health(OK, "Well.", {"a": 1}), hardware=hardware
        )
        node.ticks[DIAGNOSTICS_HZ]()
        (status,) = node.published[DIAGNOSTICS.name][-1].status
        assert [(each.key, each.value) for each in status.values] == [("tool", "left_tool"), ("a", "1")]
        assert status.hardware_id == (hardware or "left_tool")


def test_the_level_of_a_tool() -> None:
    over = Alarm(LEAK, "top_vacuum", {"kpa": 60.0}, over=True)
    low = Alarm("supply.low", "", {"warn_kpa": 450})
    assert level_of(status(alarms=(over,))) == OK, "what is over is no warning"
    assert level_of(status(alarms=(over, low))) == WARN
    assert level_of(status(missed=1)) == WARN
    assert level_of(status(link_up=False)) == level_of(status(EndEffectorState.GRIP_ERROR)) == ERROR
