"""Messages from and to the core, without a master."""

from __future__ import annotations

import io
import math
from typing import Any

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import load, profile_path
from end_effector_hal.signals import Frame

pytestmark = pytest.mark.ros
KINDS = get_codec("ees1-ascii").channels


def over_the_wire(message: Any) -> Any:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


@pytest.mark.parametrize(
    "frame",
    [
        Frame(
            2**40, 65535, 4294967295, {"bottom": -78250, "cylinder": None, "locked": False, "estop_ok": True}
        ),
        Frame(0, None, None, {"bottom": 0, "locked": None}),
        Frame(1, 0, 0, {}),
    ],
)
def test_a_frame_survives_the_topic(frame: Frame) -> None:
    from end_effector_hal.ros1._frames import frame_from_message, frame_to_message

    back = frame_from_message(over_the_wire(frame_to_message(frame)), KINDS)
    assert back == frame
    assert {name: type(value) for name, value in back.values.items()} == {
        name: type(value) for name, value in frame.values.items()
    }


def test_a_channel_that_the_codec_does_not_carry_is_left_out() -> None:
    from end_effector_hal.ros1._frames import frame_from_message, frame_to_message

    message = frame_to_message(Frame(1, 2, 3, {"bottom": 4, "humidity": 5}))
    assert dict(frame_from_message(message, KINDS).values) == {"bottom": 4}


def test_pressures_are_absolute_and_what_is_not_known_is_nan() -> None:
    from end_effector_hal.ros1._frames import absolute_pa

    assert absolute_pa(-78250) == 23075.0
    assert absolute_pa(600000) == 701325.0
    assert math.isnan(absolute_pa(None))
    assert math.isnan(absolute_pa(True)), "a bit is no pressure"


def test_margins_are_beyond_the_threshold_that_matters() -> None:
    from end_effector_hal.ros1._margins import Margins

    margins = Margins(load(profile_path()))
    for channel, gauge in (("bottom", -78000), ("cylinder", 598000), ("top", -40000), ("supply", 600000)):
        margins.take(channel, 101325.0 + gauge)
    assert margins.values(()) == [28000.0, 88000.0, -10000.0]
    assert math.isnan(margins.values({"bottom"})[0])
    assert all(math.isnan(value) for value in margins.values(None)), "a dead link leaves nothing known"
    margins.take("supply", math.nan)
    assert margins.values(())[1] == 88000.0, "without a reading of the supply its nominal pressure counts"


def test_the_outcomes_have_the_integers_of_the_message() -> None:
    from end_effector_msgs.msg import Outcome as Message

    from end_effector_hal.control.goals import Outcome

    numbers = {
        name: value for name, value in vars(Message).items() if name.isupper() and isinstance(value, int)
    }
    assert numbers == {each.name: each.value for each in Outcome}


def test_a_position_that_is_not_told_any_more_is_unknown() -> None:
    from end_effector_msgs.msg import ToolStandPosition

    from end_effector_hal.ros1._positions import Positions

    positions = Positions()
    assert positions.value("tool_stand", 0) == ToolStandPosition.UNKNOWN
    positions.take("tool_stand", ToolStandPosition(position=ToolStandPosition.AWAY), 5_000_000)
    assert positions.value("tool_stand", 6_000_000) == ToolStandPosition.AWAY
    assert positions.names(6_000_000) == {"tool_stand": "AWAY"}
    assert positions.value("tool_stand", 6_000_001) == ToolStandPosition.UNKNOWN
    assert positions.names(6_000_001) == {"tool_stand": "UNKNOWN"}


def test_the_places_of_the_tool_have_the_integers_of_the_message() -> None:
    from end_effector_msgs.msg import ToolStandPosition

    from end_effector_hal.sensing import ToolPlace

    assert {place.name: getattr(ToolStandPosition, place.name) for place in ToolPlace} == {
        place.name: place.value for place in ToolPlace
    }
