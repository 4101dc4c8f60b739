"""Topics, services and joints whose names or number depend on the tool, and the names that a tool may not use.

The joints are named as ``joint_states``, MoveIt and the URDF name them. ``<tool>_joint`` represents the whole tool:
0 gripped, `GRIP_UPPER` released. It moves nothing: a tool of vacuum cups has no opening in metres.
``<tool>_<actuator>_joint`` is the part that an actuator moves, if its description states how far.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, Fault, camel_case
from end_effector_hal.errors import DescriptionError
from end_effector_hal.kinds import Travel, kind_of
from end_effector_hal.vocabulary import Evidence

from ._table import (
    ACTIONS,
    ARM_TOOL_CHANGER,
    DIAGNOSTICS,
    END_EFFECTOR_STATE,
    FIXED_SERVICES,
    FIXED_TOPICS,
    GRIP,
    JOINT_STATES,
    NODES,
    OF_ROS,
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
    Service,
    Topic,
    pressure,
)

GRIP_UPPER = 1.0
"""Upper limit of the tool's joint, rad; the lower limit is 0."""


@dataclass(frozen=True, slots=True)
class ToolJoint:
    """The joint that one actuator moves.

    Attributes:
        name: name on the ROS graph.
        actuator: name of the actuator in the description.
        index: index of the actuator in the sequence.
        travel: its type and upper limit.
    """

    name: str
    actuator: str
    index: int
    travel: Travel

    def position(self, evidence: Sequence[int]) -> float:
        """Return the position that the evidence of all actuators proves, m or rad; NaN: none is proven."""
        ends: dict[int, float] = {Evidence.GONE: 0.0, Evidence.CONFIRMED: self.travel.upper}
        return ends.get(evidence[self.index], nan)


def grip_joint(description: Description) -> str:
    """Return the name of the joint that represents the whole tool."""
    return f"{description.name}_joint"


def grip_position(evidence: Sequence[int], uses: Sequence[bool]) -> float:
    """Return the position of that joint; NaN: none is proven.

    Args:
        evidence: of all actuators. If all of them are gone, the position is `GRIP_UPPER`.
        uses: whether each actuator grips the part. If those that do are confirmed, the position is 0.
    """
    if all(level == Evidence.CONFIRMED for level, used in zip(evidence, uses, strict=True) if used):
        return 0.0
    return GRIP_UPPER if set(evidence) == {Evidence.GONE} else nan


def actuator_joints(description: Description) -> tuple[ToolJoint, ...]:
    """Return the joints of the actuators in the order of a grip."""
    return tuple(_joints(description))


def _joints(description: Description) -> Iterator[ToolJoint]:
    for index, (name, actuator) in enumerate(description.ordered):
        if travel := kind_of(actuator).travel(actuator):
            yield ToolJoint(f"{description.name}_{name}_joint", name, index, travel)


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


OWNERS = (*NODES, *(action.name for action in ACTIONS))
"""Nodes and actions, whose names are also namespaces: ``Grip/get_loggers``, ``TriggerGrip/goal``."""
TAKEN = frozenset(
    (*OWNERS, *(each.name.lstrip("/") for each in (*FIXED_TOPICS, *FIXED_SERVICES)), *OF_ROS),
)


def load_for_nodes(path: Path) -> Description:
    """Load a tool and check that the nodes can serve it; raises DescriptionError."""
    description = load_tool(path)
    if faults := name_faults(description):
        raise DescriptionError([fault.diagnostic(str(description.source)) for fault in faults])
    return description


def name_faults(description: Description) -> tuple[Fault, ...]:
    """Return a fault for every name that the nodes could not use, with its place."""
    return tuple(sorted(set(_faults(description))))


def _faults(description: Description) -> Iterator[Fault]:
    users: dict[str, str] = {}
    for keys, kind, name in _names(description):
        place, found = description.place(*keys), f"{kind}: {name}"
        if why := _taken(name):
            yield Fault.at(place, "EE-221", f"{kind} {name!r} {why}", found=found, expected="another name")
        elif name in users:
            what = f"{kind} {name!r} is the {users[name]} already"
            yield Fault.at(place, "EE-221", what, found=found, expected="a name for each")
        users.setdefault(name, f"{kind} of {keys[1] if keys[0] in ('actuators', 'outputs') else keys[0]}")


def _names(description: Description) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """Yield the keys in the description, the kind and the name, for given names and for those made of other names."""
    changer = description.tool_changer
    if changer:
        yield ("tool_changer", "service"), "service", changer.service
    for actuator in description.sequence:
        yield ("actuators", actuator, "service"), "service", description.service_of(actuator)
        yield ("actuators", actuator, "topic"), "topic", description.topic_of(actuator)
    for output in description.outputs:
        yield ("outputs", output, "service"), "service", description.output_service_of(output)
    for actuator, topic in position_topics(description).items():
        yield ("actuators", actuator), "position topic", topic.name


def _taken(name: str) -> str:
    """Return why a description may not use a name; empty: it may. Other tools use their own namespaces."""
    words = name.split("/")
    for index in range(len(words)):
        space, rest = "/".join(words[:index]), "/".join(words[index:])
        if rest in TAKEN or rest.startswith(tuple(f"{owner}/" for owner in OWNERS)):
            return (
                f"belongs to the nodes of a tool in the namespace {space!r}"
                if space
                else "belongs to the nodes"
            )
    return ""
