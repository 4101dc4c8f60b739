"""Check the names that a program of ROS 1 is started with: the tool's, and the node's, because of two nodes
with one name the master ends the first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import rosgraph
import rospy

from end_effector_hal.description import tool_path
from end_effector_hal.errors import RosError, UsageError
from end_effector_hal.nodes.interface import DESCRIPTION, PROFILE, Parameter

from .master import NoSuchMethod, ask_master, ask_node

HOW = "_description:=FILE or _profile:=NAME"


def tool_named(argv: Sequence[str], parameter: Callable[[Parameter], str]) -> Path:
    """Return the path of the description that the arguments name, or else the private parameters.

    If the arguments name a tool, values from an earlier start on the parameter server are ignored.

    Args:
        argv: arguments of the program; ``_description:=`` and ``_profile:=`` name a tool, empty values name none.
        parameter: returns a private parameter, empty if it is not set.

    Raises:
        UsageError: neither or both are given, or no profile has that name.
    """
    given = [_argument(argv, each) for each in (DESCRIPTION, PROFILE)]
    if given == [None, None]:
        given = [parameter(DESCRIPTION), parameter(PROFILE)]
    return tool_path(given[0] or "", given[1] or "", how=HOW)


def _argument(argv: Sequence[str], parameter: Parameter) -> str | None:
    key = f"_{parameter.name}:="
    return next((each.removeprefix(key).strip() for each in argv if each.startswith(key)), None)


def node_name(name: str) -> str:
    """Return the resolved name of this process as a node: in its namespace, or as ``__name:=`` defines it."""
    called = rospy.names.get_mappings().get("__name", name)
    return str(rosgraph.names.ns_join(rospy.names.get_namespace(), called))


def refuse_taken_name(name: str, tool: str) -> None:
    """Raise RosError if a node of this name runs: it keeps running, and the new one does not start.

    A node that does not answer counts as lost, and is replaced, unless it was started for another tool.

    Args:
        name: resolved name of the new node.
        tool: path of its description; empty: it has none.
    """
    uri = ask_master("lookupNode", name)
    if uri is None:
        return
    running = _tool_of(name)
    try:
        if ask_node(str(uri), "getName") != name:
            return  # the port belongs to another node now
        state = f"process {ask_node(str(uri), 'getPid')}"
    except TimeoutError:
        if running == tool:
            return
        state = "it does not answer"
    except NoSuchMethod:
        state = "of another package"
    except OSError:
        return  # it has gone without a word to the master
    what = f"A node {name} runs already{f' for {running}' if running else ''} ({state}): it is left alone."
    raise RosError(
        what, todo=f"Give this tool a namespace (ns:=NAME), or end that node: rosnode kill {name}."
    )


def private_parameter(node: str) -> Callable[[Parameter], str]:
    """Return a function that reads the private parameters of a node, by its resolved name, from the master."""
    return lambda each: str(ask_master("getParam", f"{node}/{each.name}") or "")


def _tool_of(name: str) -> str:
    """Return the path of the description that a node was started with; empty: unknown."""
    try:
        return str(tool_named((), private_parameter(name)))
    except UsageError:
        return ""
