"""Messages from and to the core, without a master."""

from __future__ import annotations

import io
import math
from dataclasses import fields
from enum import IntEnum
from typing import Any

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Answer, EventKind
from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.hal_main._aggregate import Margins, Positions
from end_effector_hal.nodes.transport import (
    ChangerPlace,
    CommandMessage,
    CylinderPlace,
    CylinderPositionMessage,
    DiagnosticMessage,
    DiagnosticsMessage,
    EventMessage,
    FrameMessage,
    KeyValueMessage,
    MessageHeader,
    PositionMessage,
    PressureMessage,
    StateMessage,
    StatusMessage,
    StepMessage,
    absolute_pa,
    frame_from_message,
    frame_to_message,
)
from end_effector_hal.sensing import ToolPlace
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
    from end_effector_hal.ros1.connections import MessageMaker, message_class

    make = MessageMaker(message_class("end_effector_msgs/SensorFrame"))
    back = frame_from_message(over_the_wire(make(frame_to_message(frame))), KINDS)
    assert back == frame
    assert {name: type(value) for name, value in back.values.items()} == {
        name: type(value) for name, value in frame.values.items()
    }


def test_a_channel_that_the_codec_does_not_carry_is_left_out() -> None:
    message = frame_to_message(Frame(1, 2, 3, {"bottom": 4, "humidity": 5}))
    assert dict(frame_from_message(message, KINDS).values) == {"bottom": 4}


def test_pressures_are_absolute_and_what_is_not_known_is_nan() -> None:
    assert absolute_pa(-78250) == 23075.0
    assert absolute_pa(600000) == 701325.0
    assert math.isnan(absolute_pa(None))
    assert math.isnan(absolute_pa(True)), "a bit is no pressure"


def test_margins_are_beyond_the_threshold_that_matters() -> None:
    margins = Margins(load(profile_path()))
    for channel, gauge in (("bottom", -78000), ("cylinder", 598000), ("top", -40000), ("supply", 600000)):
        margins.store(channel, 101325.0 + gauge)
    assert margins.values(()) == [28000.0, 88000.0, -10000.0]
    assert math.isnan(margins.values({"bottom"})[0])
    assert all(math.isnan(value) for value in margins.values(None)), "a dead link leaves nothing known"
    margins.store("supply", math.nan)
    assert margins.values(())[1] == 88000.0, "without a reading of the supply its nominal pressure counts"


def test_the_outcomes_have_the_integers_of_the_message() -> None:
    from end_effector_msgs.msg import Outcome as Message

    from end_effector_hal.control.goals import Outcome

    numbers = {
        name: value for name, value in vars(Message).items() if name.isupper() and isinstance(value, int)
    }
    assert numbers == {each.name: each.value for each in Outcome}


def test_a_position_that_is_not_told_any_more_is_unknown() -> None:
    positions = Positions({"tool_stand": ToolPlace})
    assert positions.place("tool_stand", 0) == ToolPlace.UNKNOWN
    positions.store("tool_stand", ToolPlace.AWAY, 5_000_000)
    assert positions.place("tool_stand", 6_000_000) == ToolPlace.AWAY
    assert positions.names(6_000_000) == {"tool_stand": "AWAY"}
    assert positions.place("tool_stand", 6_000_001) == ToolPlace.UNKNOWN
    assert positions.names(6_000_001) == {"tool_stand": "UNKNOWN"}


@pytest.mark.parametrize(
    ("places", "kind"),
    [
        (ToolPlace, "ToolStandPosition"),
        (ChangerPlace, "ToolChangerPosition"),
        (CylinderPlace, "CylinderPosition"),
    ],
)
def test_the_places_have_the_integers_of_their_message(places: type[IntEnum], kind: str) -> None:
    import end_effector_msgs.msg

    constants = vars(getattr(end_effector_msgs.msg, kind)).items()
    assert {name: value for name, value in constants if name.isupper() and isinstance(value, int)} == {
        place.name: place.value for place in places
    }


@pytest.mark.parametrize(
    ("ours", "kind"),
    [
        (FrameMessage, "end_effector_msgs/SensorFrame"),
        (PressureMessage, "sensor_msgs/FluidPressure"),
        (CylinderPositionMessage, "end_effector_msgs/CylinderPosition"),
        (PositionMessage, "end_effector_msgs/ToolChangerPosition"),
        (PositionMessage, "end_effector_msgs/ToolStandPosition"),
        (CommandMessage, "end_effector_msgs/SupervisorCommand"),
        (StepMessage, "end_effector_msgs/StepReport"),
        (EventMessage, "end_effector_msgs/ToolEvent"),
        (StatusMessage, "end_effector_msgs/UnitStatus"),
        (StateMessage, "end_effector_msgs/EndEffectorState"),
        (KeyValueMessage, "diagnostic_msgs/KeyValue"),
        (DiagnosticMessage, "diagnostic_msgs/DiagnosticStatus"),
        (DiagnosticsMessage, "diagnostic_msgs/DiagnosticArray"),
    ],
)
def test_our_messages_have_the_fields_of_their_definition(ours: Any, kind: str) -> None:
    from end_effector_hal.ros1.connections import message_class

    defined = set(message_class(kind).__slots__) - ({"variance"} if ours is PressureMessage else set())
    assert {each.name for each in fields(ours)} == defined


def test_a_message_with_parts_survives_the_topic(monkeypatch: pytest.MonkeyPatch) -> None:
    import rospy

    from end_effector_hal.ros1.connections import MessageMaker, message_class

    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    make = MessageMaker(message_class("end_effector_msgs/UnitStatus"))
    status = StatusMessage(
        header=MessageHeader(frame_id="here"),
        count=7,
        evidence=(3, 1),
        outputs=(True, False),
        stale=("top",),
        steps=[StepMessage("cylinder", 2, 0.5, True)],
        events=[EventMessage(8, EventKind.TIMED_OUT, "cylinder", 2)],
    )
    back = over_the_wire(make(status))
    assert (back.header.frame_id, back.count, back.evidence) == ("here", 7, (3, 1))
    assert (back.outputs, back.stale) == ([True, False], ["top"])
    assert [(step.actuator, step.attempts, step.confirmed) for step in back.steps] == [("cylinder", 2, True)]
    assert [(each.at_us, each.event, each.actuator) for each in back.events] == [(8, "timed out", "cylinder")]
    again = over_the_wire(make(StatusMessage(steps=back.steps)))
    assert again.steps == back.steps, "steps that were received can be sent on"


def test_an_answer_becomes_the_response_of_any_service() -> None:
    from end_effector_hal.ros1.connections import answer_of, response_maker, service_class

    for kind in ("std_srvs/SetBool", "std_srvs/Trigger"):
        response = over_the_wire(response_maker(service_class(kind))(Answer(False, "why not")))
        assert answer_of(response) == Answer(False, "why not")
    respond = response_maker(service_class("end_effector_msgs/HalCommand"))
    response = over_the_wire(respond(Answer(True, "", False, 7)))
    assert (response.accepted, response.reason, response.count, response.decided) == (True, "", 7, False)
