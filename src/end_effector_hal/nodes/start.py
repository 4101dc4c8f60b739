"""Start a node by its name, and open the tool of its process; only the modules of that node are imported."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime import EndEffector, RemoteTool, Tool

from .interface import (
    CONNECT,
    DATA_LOGGER,
    DIRECTORY,
    GRIP,
    HAL_MAIN,
    KEEP_MB,
    POSITION,
    PRESSURE,
    SEGMENT_MB,
    STATE_HZ,
    SUPERVISOR,
    TOOL_CHANGE,
    Parameter,
)
from .transport import NodeTransport


def recording_limits(node: NodeTransport) -> RecordingLimits:
    """Return the limits of ``~segment_mb`` and ``~keep_mb``, or the defaults; raises UsageError if they are invalid."""
    return RecordingLimits.of_megabytes(_number(node, SEGMENT_MB, "64"), _number(node, KEEP_MB, "1000"))


def _number(node: NodeTransport, parameter: Parameter, default: str) -> float:
    text = node.parameter(parameter) or default
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"The parameter {parameter.name} is {text[:40]!r}, expected are megabytes."
        ) from None


def open_tool(node: NodeTransport, *, hosts: bool) -> Tool:
    """Open the tool of a process. It starts when all nodes exist, so that each gets every status, and ends with them.

    Args:
        node: the node HALMain if it runs in this process, else any node of it.
        hosts: whether HALMain runs in this process: then the tool does, unless the parameter ``connect`` is true.

    Raises:
        WireError: there is no line arbiter, or another process runs this tool.
    """
    description = node.description()
    if not hosts or node.parameter(CONNECT).lower() == "true":
        connected = RemoteTool(description)
        node.on_close(connected.close)
        node.on_start(connected.start)
        return connected
    folder = node.parameter(DIRECTORY)
    traces = Path(folder).expanduser() if folder else None
    tool = EndEffector(description, traces=traces, limits=recording_limits(node))

    def check() -> None:
        if not tool.alive:
            node.fail(ReportedError("The program of the tool has failed."))

    node.on_close(tool.close)
    node.every(STATE_HZ, check)
    node.on_start(tool.start)
    return tool


PROGRAMS = {
    "pressure": PRESSURE,
    "position": POSITION,
    "grip": GRIP,
    "tool_change": TOOL_CHANGE,
    "hal_main": HAL_MAIN,
    "data_logger": DATA_LOGGER,
    "supervisor": SUPERVISOR,
}
"""The node of each executable."""
_NODES = {
    HAL_MAIN: ("_hal_main", "HalMainNode"),
    GRIP: ("_services", "GripNode"),
    TOOL_CHANGE: ("_services", "ToolChangeNode"),
    PRESSURE: ("_pressure", "PressureNode"),
    POSITION: ("_position", "PositionNode"),
    DATA_LOGGER: ("data_logger", "DataLogger"),
    SUPERVISOR: ("_supervisor", "run_supervisor"),
}


def start_node(name: str, node: NodeTransport) -> int | None:
    """Start a node of the interface table.

    Args:
        name: name of the node in the interface table.
        node: its transport.

    Returns:
        None: the node works in the threads of its transport, until that ends. Only the Supervisor works in the calling
            thread; then its exit code is returned.
    """
    module, what = _NODES[name]
    started = getattr(import_module(f"{__package__}.{module}"), what)(node)
    return started if name == SUPERVISOR else None
