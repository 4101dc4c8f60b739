"""A real roscore, the shipped launch file, the line arbiter and the testbench: started once for all tests."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import xmlrpc.client
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import RosError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._ros import Master, free_port
from end_effector_lab.demo._world import World
from end_effector_lab.processes import Child
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.small_disk import small_disk

ROS = all(importlib.util.find_spec(name) for name in ("rospy", "end_effector_msgs")) and all(
    shutil.which(name) for name in ("roscore", "roslaunch", "rosrun")
)
START_S = 90.0


OF_ROSPY = r"ignore:.*(notifyAll|setDaemon|getName|setName|isSet|currentThread)\(\) is deprecated"


def pytest_collection_modifyitems(items: Sequence[pytest.Item]) -> None:
    for item in items:
        if not item.get_closest_marker("ros"):
            continue
        if "acceptance/ros1/" in item.nodeid:  # what is the same in either ROS stands in the contract
            item.add_marker(pytest.mark.thinned)
        # rospy 1.15 is older than this Python's warnings; a warning in its threads would stop them
        item.add_marker(pytest.mark.filterwarnings(f"{OF_ROSPY}:DeprecationWarning"))
        item.add_marker(pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning"))
        if not ROS:
            item.add_marker(pytest.mark.skip(reason="no ROS here, or its workspace is not sourced"))


class Goal:
    """A goal of an action client, with everything that came of it."""

    def __init__(self, client: Any, goal: Any) -> None:
        self.feedback: list[Any] = []
        self.handle = client.send_goal(goal, feedback_cb=lambda _, message: self.feedback.append(message))

    def ended(self) -> bool:
        import actionlib

        return bool(self.handle.get_comm_state() == actionlib.CommState.DONE)

    def result(self, timeout_s: float = PATIENCE_S) -> tuple[int, Any]:
        """Status of actionlib, and the result."""
        wait_until("a result", self.ended, timeout_s)
        return self.handle.get_goal_status(), self.handle.get_result()


SUCCEEDED = 3
"""Of actionlib."""


class System:
    """What the tests act upon: the running nodes, from outside."""

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder = world, folder
        self.ros = Master(folder / "ros")
        self.env = dict(self.ros.env)
        self.states: list[Any] = []
        self._clients: dict[str, Any] = {}

    until = staticmethod(wait_until)
    free_port = staticmethod(free_port)

    def start(self, name: str, *command: str, env: Mapping[str, str] | None = None, **options: Any) -> Child:
        """A process with this master; its log is ``<name>.log``."""
        return self.world.children.start(
            name,
            command,
            log=self.folder / f"{name}.log",
            failed=RosError,
            env={**self.env, **(env or {})},
            **options,
        )

    def launch(
        self, world: World, *arguments: str, name: str = "launch", env: Mapping[str, str] | None = None
    ) -> Child:
        """The shipped launch file on the lines and the link of a world."""
        return self.start(
            name, "roslaunch", "--wait", "end_effector_hal", "end_effector.launch",
            f"description:={world.description_path}", "arbiter:=false", *arguments,
            env=env, end_by=signal.SIGINT, patience_s=20.0,
        )  # fmt: skip

    def cli(
        self, *command: str, timeout_s: float = PATIENCE_S, typed: str = ""
    ) -> subprocess.CompletedProcess[str]:
        """A command of ROS, to its end."""
        return subprocess.run(
            command,
            env={**self.world.children.env, **self.env},
            input=typed,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )

    def connect(self) -> None:
        """Become a node."""
        os.environ.update({key: self.env[key] for key in ("ROS_MASTER_URI", "ROS_IP", "ROS_LOG_DIR")})
        import actionlib
        import rospy
        from end_effector_msgs.msg import EndEffectorAction
        from end_effector_msgs.msg import EndEffectorState as Message

        rospy.init_node("tests", disable_signals=True)
        rospy.Subscriber("EndEffectorState", Message, self.states.append, queue_size=500, tcp_nodelay=True)
        # all publishers of a topic in this process share the queue of the first: its ten would drop goals of a flood
        rospy.set_param("actionlib_client_pub_queue_size", 5000)
        for name in ("LockToolChanger", "UnlockToolChanger", "TriggerGrip", "Drop"):
            self._clients[name] = actionlib.ActionClient(name, EndEffectorAction)
        for name, client in self._clients.items():
            assert client.wait_for_server(rospy.Duration(60)), name
        self.wait_for(EndEffectorState.STAND_BY)

    @property
    def state(self) -> Any:
        """The newest EndEffectorState."""
        return self.states[-1]

    def wait_for(self, *states: EndEffectorState, timeout_s: float = PATIENCE_S) -> Any:
        """The newest message, once it has one of these states."""
        wait_until(
            " or ".join(state.name for state in states),
            lambda: self.states and self.state.state in states and self.state.command == -1,
            timeout_s,
        )
        return self.state

    def send(self, action: str) -> Goal:
        """Send a goal, once its server is there: a HALMain that has just returned is connected one by one."""
        import rospy
        from end_effector_msgs.msg import EndEffectorGoal

        client = self._clients[action]
        wait_until(f"the server of {action}", lambda: client.wait_for_server(rospy.Duration(1)))
        return Goal(client, EndEffectorGoal())

    def run(self, action: str) -> tuple[int, Any]:
        """Send a goal and wait for its result."""
        return self.send(action).result()

    def grip(self) -> None:
        """Grip, and have it: the result and the state come over two connections, in any order."""
        begun = len(self.states)
        status, result = self.run("TriggerGrip")
        assert status == SUCCEEDED, result.reason
        gripped = EndEffectorState.GRIPPED
        wait_until("GRIPPED", lambda: any(message.state == gripped for message in self.states[begun:]))

    def pid_of(self, node: str) -> int:
        """The process of a node."""
        import rosgraph

        proxy: Any = xmlrpc.client.ServerProxy(rosgraph.Master("/tests").lookupNode(node))
        return int(proxy.getPid("/tests")[2])

    def edges(self) -> list[tuple[str, int]]:
        """Every write to the lines so far, from the log of the virtual chip."""
        records = [json.loads(line) for line in self.world.chip.read_text().splitlines() if line.strip()]
        return [(record["line"], record["level"]) for record in records if "line" in record]

    def rest(self) -> None:
        """Nothing is gripped, nothing is wrong."""
        self.world.choose("nominal")
        wait_until("the link", lambda: self.state.link_up)
        state = self.wait_for(*set(EndEffectorState) - {EndEffectorState.OFF})
        if state.state != EndEffectorState.STAND_BY:
            # on a busy machine a command is too late, or a reading is stale: then it is given again
            wait_until("a drop", lambda: self.run("Drop")[0] == SUCCEEDED)
            self.wait_for(EndEffectorState.STAND_BY)
        wait_until(
            "absence of all", lambda: list(self.state.evidence) == [1, 1, 1] and self.state.tool_changer == 1
        )


def quick() -> Description:
    """The shipped tool with shorter time-outs, still many times what a confirmation takes."""
    tool = load(profile_path())
    actuators = {
        name: actuator.model_copy(update={"timeout_s": 3.0}) for name, actuator in tool.actuators.items()
    }
    return tool.model_copy(update={"actuators": actuators})


@pytest.fixture(scope="session")
def session_system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[System]:
    folder = tmp_path_factory.mktemp("ros")
    # what is recorded goes to a disk of its own, which a test can fill
    with (
        small_disk(folder / "log", megabytes=256) as disk,
        World(quick(), "nominal", folder) as world,
    ):
        system = System(world, folder)
        system.disk = disk  # type: ignore[attr-defined]
        system.ros.start(world.children, folder / "roscore.log", patience_s=START_S)
        # given up after 30 s; meanwhile the other tests run
        system.lonely = system.start(  # type: ignore[attr-defined]
            "lonely", "rosrun", "end_effector_hal", "supervisor", "__ns:=nowhere", "_script:=grip"
        )
        system.launch(world, f"log_directory:={folder / 'log'}")
        system.connect()
        yield system


@pytest.fixture
def system(session_system: System) -> System:
    """The running system, in STAND_BY, with nothing wrong at the testbench."""
    session_system.rest()
    return session_system
