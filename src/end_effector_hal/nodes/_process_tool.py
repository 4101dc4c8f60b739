"""The tool of a process: run here, or over the socket of the HAL that runs it."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime import EndEffector, RemoteTool, Tool

from ._recording_limits import recording_limits
from .interface import CONNECT, DIRECTORY, STATE_HZ
from .transport import NodeTransport


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
