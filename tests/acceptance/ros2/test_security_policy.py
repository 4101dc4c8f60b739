"""What the nodes do on the graph is what ``eehal export sros2`` allows them, no more and no less."""

from __future__ import annotations

import importlib.util
from collections import defaultdict
from pathlib import Path
from typing import Any

from end_effector_hal.cli.export._sros2 import security_policy
from end_effector_hal.nodes.interface import ACTIONS, DATA_LOGGER, HAL_NODES, SUPERVISOR
from end_effector_hal.ros2 import PROGRAMS
from tests.support.sros2 import Allowed, read_policy

NOT_SERVED = tuple(
    f"/{action.name}/"
    for action in ACTIONS
    if action.optional and importlib.util.find_spec(action.type.partition("/")[0]) is None
)


def test_the_graph_is_the_policy(system: Any, tmp_path: Path) -> None:
    text = security_policy(system.world.description, five=system.five)
    policy = read_policy(text)
    node = system.node
    questions = {
        "publish": node.get_publisher_names_and_types_by_node,
        "subscribe": node.get_subscriber_names_and_types_by_node,
        "reply": node.get_service_names_and_types_by_node,
        "request": node.get_client_names_and_types_by_node,
    }
    others = {"data_logger": DATA_LOGGER, "supervisor": SUPERVISOR}
    started = [
        system.start(program, "-p", f"directory:={tmp_path}", "-p", "script:=wait 60; quit")
        for program in others
    ]
    nodes = {*HAL_NODES, *others.values()}
    system.until("all nodes on the graph", lambda: nodes <= set(node.get_node_names()))
    for program in (*system.programs, *others):
        found: Allowed = defaultdict(set)
        for name in PROGRAMS[program]:
            for right, ask in questions.items():
                found[right] |= {entity for entity, _ in ask(name, "/")}
        allowed = policy[f"/{system.world.description.name}/{program}"]
        if program == "supervisor":  # it makes a client when it calls
            found["request"] |= {"/ArmToolChanger", "/ResetFaults"}
        for right in questions:
            served = {each for each in allowed[right] if not each.startswith(NOT_SERVED)}
            assert found[right] == served, (program, right)
    for child in started:
        child.end()
