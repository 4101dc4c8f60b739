"""Writes the table of the ROS interface as an SROS 2 policy: each process may do what its nodes do, and
nothing else.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.interface import (
    ACTIONS,
    ARM_TOOL_CHANGER,
    COMMAND_ACTIONS,
    DATA_LOGGER,
    HAL_MAIN,
    HAL_NODES,
    MANAGER,
    RESET_FAULTS,
    RESUME_GRIP,
    STOP_TOOL,
    SUPERVISOR,
    load_for_nodes,
    services,
    topics,
)
from end_effector_hal.ros2 import MANAGED, PROGRAMS

from ._options import PathName, write_or_print

VERSION = "0.2.0"
CLIENT, OPERATOR = "client", "operator"
PROCESSES = ("one", "five", "managed")
OWN_TOPICS = ("/rosout", "/parameter_events")
"""Topics that every node of rclpy publishes."""
OWN_SERVICES = tuple(
    f"~/{each}"
    for each in (
        "describe_parameters",
        "get_parameter_types",
        "get_parameters",
        "get_type_description",
        "list_parameters",
        "set_parameters",
        "set_parameters_atomically",
    )
)
"""Services that every node of rclpy offers."""
OF_LIFECYCLE = tuple(
    f"~/{each}"
    for each in (
        "change_state",
        "get_available_states",
        "get_available_transitions",
        "get_state",
        "get_transition_graph",
    )
)
"""Services that a managed node offers in addition."""
CALLED = {SUPERVISOR: (ARM_TOOL_CHANGER, RESUME_GRIP, STOP_TOOL, RESET_FAULTS)}
"""Services that a node of this package calls."""
_NAME = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/")


@click.command(name="sros2", short_help="An SROS 2 policy: which process may publish, serve and call what.")
@click.argument("file", type=PathName(), required=False)
@click.option(
    "--processes",
    type=click.Choice(PROCESSES),
    default="one",
    show_default=True,
    help="Of the HAL, as the launch file has them.",
)
@click.option("--namespace", metavar="NS", default="", help="ROS namespace of the tool, such as /left.")
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_sros2(file: Path | None, processes: str, namespace: str, output: Path | None) -> None:
    """Write policy.xml for the tool of the description FILE; default: the shipped one.

    The policy has an enclave for each process: /NAME/hal, its five programs or /NAME/lifecycle_hal, /NAME/data_logger,
    /NAME/supervisor, and /NAME/client for a program that commands the tool (managed: /NAME/operator for the program
    that configures and activates it). NAME is the namespace, or else the name of the tool.
    """
    description = load_for_nodes(file or profile_path())
    write_or_print(output, security_policy(description, processes, namespace), description.files)


def security_policy(description: Description, processes: str = "one", namespace: str = "") -> str:
    """Return the text of ``policy.xml``.

    Args:
        processes: how the HAL is divided into processes, one of `PROCESSES`.
        namespace: namespace of all nodes.

    Raises:
        UsageError: the namespace is not valid.
    """
    space = "/" + namespace.strip("/")
    words = space.split("/")[1:]
    if not _NAME.issuperset(space) or any(
        word[:1].isdigit() or (not word and space != "/") for word in words
    ):
        raise UsageError(f"{namespace!r} is not a namespace.", todo="Write one such as /cell_1/left.")
    policy = ET.Element("policy", version=VERSION)
    policy.append(ET.Comment(f" Of {description.name}, by `eehal export sros2`; not edited by hand. "))
    enclaves = ET.SubElement(policy, "enclaves")
    prefix = space if space != "/" else f"/{description.name}"
    for program, nodes in _processes(processes):
        enclave = ET.SubElement(enclaves, "enclave", path=f"{prefix}/{program}")
        profiles = ET.SubElement(enclave, "profiles")
        for node in nodes:
            profile = ET.SubElement(profiles, "profile", ns=space, node=node)
            _fill(profile, node, description)
    ET.indent(policy)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(policy, encoding="unicode")}\n'


def _processes(processes: str) -> Iterator[tuple[str, Sequence[str]]]:
    alone = {nodes[0]: program for program, nodes in PROGRAMS.items() if len(nodes) == 1}
    if processes == "five":
        yield from ((alone[node], (node,)) for node in HAL_NODES)
    elif processes == "managed":
        yield MANAGED, (MANAGER, *PROGRAMS[MANAGED])
        yield OPERATOR, (OPERATOR,)
    else:
        yield "hal", PROGRAMS["hal"]
    yield from ((alone[node], (node,)) for node in (DATA_LOGGER, SUPERVISOR))
    yield CLIENT, (CLIENT,)


def _fill(profile: ET.Element, node: str, description: Description) -> None:
    client = node == CLIENT
    lifecycle = node == MANAGER
    own = (*OWN_TOPICS, *(("~/transition_event",) if lifecycle else ()))
    every = topics(description)
    _allow(profile, "topics", "publish", (*own, *(each.name for each in every if node in each.publishers)))
    heard = [each.name for each in every if node in each.subscribers or client]
    _allow(profile, "topics", "subscribe", heard)
    served = (*OWN_SERVICES, *(OF_LIFECYCLE if lifecycle else ()))
    offered = [each.name for each in services(description) if each.server == node]
    _allow(profile, "services", "reply", (*served, *offered))
    called = [each.name for each in services(description) if client or each in CALLED.get(node, ())]
    if node == OPERATOR:
        called += [f"{MANAGER}/{each}" for each in ("change_state", "get_state")]
    _allow(profile, "services", "request", called)
    if node == HAL_MAIN:
        _allow(profile, "actions", "execute", [action.name for action in ACTIONS])
    if client or node == SUPERVISOR:
        _allow(profile, "actions", "call", [each.name for each in (ACTIONS if client else COMMAND_ACTIONS)])


def _allow(profile: ET.Element, kind: str, right: str, names: Sequence[str]) -> None:
    if names:
        listed = ET.SubElement(profile, kind, {right: "ALLOW"})
        for name in sorted(set(names)):
            ET.SubElement(listed, kind.removesuffix("s")).text = name
