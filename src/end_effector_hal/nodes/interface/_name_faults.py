"""Find names in a description that the nodes use themselves, or that would be ambiguous on the ROS graph."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, Fault
from end_effector_hal.errors import DescriptionError

from ._table import ACTIONS, FIXED_SERVICES, FIXED_TOPICS, NODES, OF_ROS
from ._tool import position_topics

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
