"""Start a node by its name; only the modules of that node are imported."""

from __future__ import annotations

from importlib import import_module

from .interface import DATA_LOGGER, GRIP, HAL_MAIN, POSITION, PRESSURE, SUPERVISOR, TOOL_CHANGE
from .transport import NodeTransport

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
    HAL_MAIN: ("hal_main", "HalMainNode"),
    GRIP: ("_grip", "GripNode"),
    TOOL_CHANGE: ("_tool_change", "ToolChangeNode"),
    PRESSURE: ("_pressure", "PressureNode"),
    POSITION: ("_position", "PositionNode"),
    DATA_LOGGER: ("data_logger", "DataLogger"),
    SUPERVISOR: ("supervisor", "run_supervisor"),
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
