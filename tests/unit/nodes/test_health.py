"""What ``/diagnostics`` says of a node."""

from __future__ import annotations

from typing import Any, cast

from end_effector_hal.nodes.interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.nodes.report import OK, Health, publish_health, standing
from end_effector_hal.vocabulary import LEAK, Alarm
from tests.support.lone_node import LoneTransport


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


def test_what_is_over_is_no_warning() -> None:
    over, low = (
        Alarm(LEAK, "top_vacuum", {"kpa": 60.0}, over=True),
        Alarm("supply.low", "", {"warn_kpa": 450}),
    )
    assert (standing((over,)), standing((over, low))) == (False, True)
