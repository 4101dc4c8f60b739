"""Topics and services whose names or number depend on the tool."""

from __future__ import annotations

from end_effector_hal.description import Description, camel_case
from end_effector_hal.kinds import kind_of

from ._entries import Service, Topic
from ._table import (
    ARM_TOOL_CHANGER,
    DIAGNOSTICS,
    END_EFFECTOR_STATE,
    GRIP,
    JOINT_STATES,
    POSITION,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    PRESSURE_SUPPLY,
    RESET_FAULTS,
    RESUME_GRIP,
    STATE_HZ,
    STOP_TOOL,
    SUPERVISOR_COMMANDS,
    TOOL_CHANGE,
    pressure,
)


def pressure_topic(description: Description, actuator: str) -> Topic:
    """Return the topic of an actuator's absolute pressure; raises KeyError for an unknown actuator."""
    return pressure(description.topic_of(actuator))


def pressure_topics(description: Description) -> tuple[tuple[str, Topic], ...]:
    """Return pairs of a channel of the link and its topic: the actuators in sequence order, then the supply."""
    own = ((actuator.channel, pressure_topic(description, name)) for name, actuator in description.ordered)
    return (*own, (description.supply.channel, PRESSURE_SUPPLY))


def position_topics(description: Description) -> dict[str, Topic]:
    """Return the position topic of each actuator that moves between two end positions."""
    return {
        name: Topic(
            "Position" + camel_case(name), "end_effector_msgs/CylinderPosition", (POSITION,),
            rate_hz=STATE_HZ, latched=True,
        )
        for name, actuator in description.ordered
        if kind_of(actuator).moves
    }  # fmt: skip


def set_services(description: Description) -> dict[str, Service]:
    """Return the ``/Set*`` service of each actuator."""
    return {name: _set(description.service_of(name), GRIP) for name in description.sequence}


def output_services(description: Description) -> dict[str, Service]:
    """Return the ``/Set*`` service of each plain output."""
    return {name: _set(description.output_service_of(name), GRIP) for name in description.outputs}


def set_tool_changer(description: Description) -> Service | None:
    """Return the service of the tool changer; None: the tool has no changer."""
    return _set(description.tool_changer.service, TOOL_CHANGE) if description.tool_changer else None


def topics(description: Description) -> tuple[Topic, ...]:
    """Return all topics of a tool."""
    changer = (POSITION_TOOL_CHANGER, POSITION_TOOL_STAND) if description.tool_changer else ()
    return (
        END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, *(topic for _, topic in pressure_topics(description)),
        *position_topics(description).values(), JOINT_STATES, *changer,
        DIAGNOSTICS,
    )  # fmt: skip


def services(description: Description) -> tuple[Service, ...]:
    """Return all services of a tool."""
    changer = set_tool_changer(description)
    plain = output_services(description).values()
    own = (*set_services(description).values(), *plain, *((changer, ARM_TOOL_CHANGER) if changer else ()))
    return (*own, RESUME_GRIP, STOP_TOOL, RESET_FAULTS)


def _set(name: str, server: str) -> Service:
    return Service(name, "std_srvs/SetBool", server)
