"""What the nodes do on the graph is what ``eehal export sros2`` allows them, no more and no less."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from end_effector_hal.cli._sros2 import security_policy
from end_effector_hal.nodes.interface import DATA_LOGGER, HAL_NODES, SUPERVISOR
from end_effector_hal.ros2 import PROGRAMS
from tests.support.sros2 import on_graph, read_policy


def seen(system: Any, program: str) -> Any:
    """What a program does on the graph."""
    found = on_graph(system.node, PROGRAMS[program])
    if program == "supervisor":  # it makes a client when it calls
        found["request"] |= {"/ArmToolChanger", "/ResumeGrip", "/StopTool", "/ResetFaults"}
    return found


def is_seen(system: Any, program: str, allowed: Any) -> bool:
    return bool(seen(system, program) == allowed)


def test_the_graph_is_the_policy(system: Any, tmp_path: Path) -> None:
    policy = read_policy(security_policy(system.world.description, "five" if system.five else "one"))
    others = {"data_logger": DATA_LOGGER, "supervisor": SUPERVISOR}
    started = [
        system.start(program, "-p", f"directory:={tmp_path}", "-p", "script:=wait 60; quit")
        for program in others
    ]
    nodes = {*HAL_NODES, *others.values()}
    system.until("all nodes on the graph", lambda: nodes <= set(system.node.get_node_names()))
    for program in (*system.programs, *others):
        allowed = policy[f"/{system.world.description.name}/{program}"].served()
        with suppress(AssertionError):  # a node is on the graph before all that it does is
            system.until("all of it on the graph", partial(is_seen, system, program, allowed))
        assert seen(system, program) == allowed, program
    for child in started:
        child.end()
