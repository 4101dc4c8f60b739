"""Messages from and to the core, without a master."""

from __future__ import annotations

import io
import math
from dataclasses import fields
from enum import IntEnum
from typing import Any

import pytest

from end_effector_hal.control import Answer, EventKind, StepReport, ToolEvent
from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes._hal_main import Aggregate
from end_effector_hal.nodes._position import ChangerPlace, CylinderPlace
from end_effector_hal.nodes._pressure import absolute_pa
from end_effector_hal.nodes.transport import (
    CommandMessage,
    CylinderPositionMessage,
    DiagnosticMessage,
    DiagnosticsMessage,
    EventMessage,
    GoalMessage,
    KeyValueMessage,
    PositionMessage,
    PressureMessage,
    StateMessage,
    StepMessage,
)
from end_effector_hal.sensing import ToolPlace
from end_effector_hal.vocabulary import Evidence
from tests.support.lone_node import status

pytestmark = pytest.mark.ros


def over_the_wire(message: Any) -> Any:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def test_pressures_are_absolute_and_what_is_not_known_is_nan() -> None:
    assert absolute_pa(-78250) == 23075.0
    assert absolute_pa(600000) == 701325.0
    assert math.isnan(absolute_pa(None))
    assert math.isnan(absolute_pa(True)), "a bit is no pressure"


def test_margins_are_beyond_the_threshold_that_matters() -> None:
    aggregate = Aggregate(load(profile_path()), 0)

    def margins(**values: int | None) -> list[float]:
        return list(aggregate.message(status(), values, 0, count=0, stamp_us=None).margins)

    known = {"bottom": -78000, "cylinder": 598000, "top": -40000, "supply": 600000}
    assert margins(**known) == [28000.0, 88000.0, -10000.0]
    assert math.isnan(margins(**{**known, "bottom": None})[0])
    assert all(math.isnan(value) for value in margins()), "a dead link leaves nothing known"
    supplied = margins(**{**known, "supply": None})[1]
    assert supplied == 88000.0, "without a reading of the supply its nominal pressure counts"


def test_the_outcomes_have_the_integers_of_the_message() -> None:
    from end_effector_msgs.msg import Outcome as Message

    from end_effector_hal.control.goals import Outcome

    numbers = {
        name: value for name, value in vars(Message).items() if name.isupper() and isinstance(value, int)
    }
    assert numbers == {each.name: each.value for each in Outcome}


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
        (PressureMessage, "sensor_msgs/FluidPressure"),
        (CylinderPositionMessage, "end_effector_msgs/CylinderPosition"),
        (PositionMessage, "end_effector_msgs/ToolChangerPosition"),
        (PositionMessage, "end_effector_msgs/ToolStandPosition"),
        (CommandMessage, "end_effector_msgs/SupervisorCommand"),
        (GoalMessage, "end_effector_msgs/EndEffectorGoal"),
        (StepMessage, "end_effector_msgs/StepReport"),
        (EventMessage, "end_effector_msgs/ToolEvent"),
        (StateMessage, "end_effector_msgs/EndEffectorState"),
        (KeyValueMessage, "diagnostic_msgs/KeyValue"),
        (DiagnosticMessage, "diagnostic_msgs/DiagnosticStatus"),
        (DiagnosticsMessage, "diagnostic_msgs/DiagnosticArray"),
    ],
)
def test_our_messages_have_the_fields_of_their_definition(ours: Any, kind: str) -> None:
    from end_effector_hal.ros1._messages import message_class

    defined = set(message_class(kind).__slots__) - ({"variance"} if ours is PressureMessage else set())
    assert {each.name for each in fields(ours)} == defined


def test_a_message_with_parts_survives_the_topic(monkeypatch: pytest.MonkeyPatch) -> None:
    import rospy

    from end_effector_hal.ros1._messages import MessageMaker, message_class

    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    make = MessageMaker(message_class("end_effector_msgs/EndEffectorState"))
    whole = status(
        evidence=(Evidence.CONFIRMED, Evidence.GONE, Evidence.GONE),
        stale=("top",),
        steps=(StepReport("cylinder", 2, 0.5, confirmed=True),),
        events=(ToolEvent(8, EventKind.TIMED_OUT, 1, 2),),
    )
    message = Aggregate(load(profile_path()), 0).message(whole, {}, 0, count=7, stamp_us=None)
    back = over_the_wire(make(message))
    assert (back.count, back.evidence, back.stale) == (7, (3, 1, 1), ["top"])
    assert [(step.actuator, step.attempts, step.confirmed) for step in back.steps] == [("cylinder", 2, True)]
    assert [(each.at_us, each.event, each.actuator) for each in back.events] == [(8, "timed out", "cylinder")]


def test_an_answer_becomes_the_response_of_any_service() -> None:
    from end_effector_hal.nodes.transport import answer_of
    from end_effector_hal.ros1._messages import response_maker, service_class

    for kind in ("std_srvs/SetBool", "std_srvs/Trigger"):
        response = over_the_wire(response_maker(service_class(kind))(Answer(False, "why not")))
        assert answer_of(response) == Answer(False, "why not")
