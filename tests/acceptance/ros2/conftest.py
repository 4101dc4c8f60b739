"""The nodes on real ROS 2, in one process and in five, with the line arbiter and the testbench.

They run in the environment of `make ros2` only: ROS 1 and ROS 2 have the same import names.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import RosError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._ros import FIVE, ONE, PROGRAM, apart
from end_effector_lab.demo._world import World
from end_effector_lab.processes import Child
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.places import ROOT

PACKAGE = ROOT / "ros" / "end_effector_hal"
STROKE_MM = 80.0
"""Of the cylinder: the description of the paper's tool has none."""

OF_WHEELS = ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
"""What the wheels leave in the environment for their own process, when they are imported."""

collect_ignore_glob = [] if importlib.util.find_spec("rclpy") else ["test_*.py"]


def without_wheels() -> dict[str, str]:
    """The environment for a process that imports them anew, or others; no ROS is sourced there."""
    return {
        name: value
        for name, value in os.environ.items()
        if name not in OF_WHEELS and not name.startswith("ROS_")
    }


class Sent:
    """A goal that was sent, with everything that came of it."""

    def __init__(self, executor: Any, client: Any, goal: Any) -> None:
        self.feedback: list[Any] = []
        self._executor = executor
        future = self._ask(
            client.send_goal_async, goal, lambda message: self.feedback.append(message.feedback)
        )
        wait_until("the goal was answered", future.done)
        self.handle = future.result()
        self._result = self._ask(self.handle.get_result_async)

    def ended(self) -> bool:
        return bool(self._result.done())

    def result(self, timeout_s: float = PATIENCE_S) -> tuple[int, Any]:
        """Status of the action, and the result."""
        wait_until("a result", self.ended, timeout_s)
        response = self._result.result()
        return response.status, response.result

    def cancel(self) -> bool:
        """Ask for a cancel; whether it was taken."""
        future = self._ask(self.handle.cancel_goal_async)
        wait_until("the cancel was answered", future.done)
        return bool(future.result().goals_canceling)

    def _ask(self, question: Any, *arguments: Any) -> Any:
        """In the executor's thread: rclpy drops an answer that comes before it has noted the question."""
        task = self._executor.create_task(question, *arguments)
        wait_until("the question was sent", task.done)
        return task.result()


class System:
    """What the tests act upon: the running nodes, and a node of the test."""

    def __init__(self, world: World, folder: Path, programs: Sequence[str]) -> None:
        self.world, self.folder, self.programs = world, folder, programs
        self.env = {**apart(folder / "ros"), "ROS_PYTHON_CHECK_FIELDS": "1"}
        self.nodes: dict[str, Child] = {}
        self.states: list[Any] = []
        self._numbers = iter(range(1000))

    until = staticmethod(wait_until)

    @property
    def five(self) -> bool:
        return len(self.programs) > 1

    def start(self, program: str, *arguments: str, env: Mapping[str, str] | None = None) -> Child:
        """A program of the nodes, with the tool of this world."""
        tool = ("--ros-args", "-p", f"description:={self.world.description_path.absolute()}")
        return self.world.children.start(
            program, [*PROGRAM, program, *tool, *arguments],
            log=self.folder / f"{program}-{next(self._numbers)}.log", failed=RosError, env={**self.env, **(env or {})},
            end_by=signal.SIGINT, patience_s=20.0,
        )  # fmt: skip

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """A program of the nodes, to its end."""
        return subprocess.run(
            [*PROGRAM, *arguments], env={**os.environ, **self.env}, capture_output=True, text=True,
            timeout=PATIENCE_S, check=False,
        )  # fmt: skip

    def start_nodes(self) -> None:
        for program in self.programs:
            self.nodes[program] = self.start(program, "-p", f"directory:={self.folder / 'traces'}")

    def kill_nodes(self, number: int) -> None:
        for child in self.nodes.values():
            os.kill(child.pid, number)
        for child in self.nodes.values():
            self.until("its end", lambda child=child: child.code is not None)

    def join(self) -> None:
        """Become a node."""
        os.environ.update(self.env)
        import rclpy
        from end_effector_msgs.action import EndEffector
        from end_effector_msgs.msg import EndEffectorState as Message
        from rclpy.action import ActionClient
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self.context = Context()
        rclpy.init(context=self.context)
        self.node = Node("tests", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(Message, "EndEffectorState", self.states.append, self.latched)
        names = ("LockToolChanger", "UnlockToolChanger", "TriggerGrip", "Drop")
        self._clients = {name: ActionClient(self.node, EndEffector, name) for name in names}
        self._goal = EndEffector.Goal
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        """Until `close`: rclpy's own loop may be about to use what a shutdown destroys."""
        while not self._closing.is_set():
            self.executor.spin_once(timeout_sec=0.2)

    def connect(self, state: EndEffectorState = EndEffectorState.STAND_BY) -> None:
        """Find the servers of the actions."""
        for name, client in self._clients.items():
            assert client.wait_for_server(PATIENCE_S), name
        self.wait_for(state)
        wait_until("the readings of a second", self._has_heard_a_second)

    def _has_heard_a_second(self) -> bool:
        """No reading was stale: while many processes start, one is now and then, and a grip is refused (IL-07)."""
        before = len(self.states) - 1
        time.sleep(1.0)
        return not any(state.stale for state in self.states[before:])

    def close(self) -> None:
        self._closing.set()
        self._thread.join(5.0)
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()

    @property
    def state(self) -> Any:
        """The newest EndEffectorState."""
        return self.states[-1]

    def wait_for(self, *states: EndEffectorState) -> Any:
        """The newest message, once it has one of these states and nothing is executed."""
        wait_until(
            " or ".join(state.name for state in states),
            lambda: self.states and self.state.state in states and self.state.command == -1,
        )
        return self.state

    def send(self, name: str) -> Sent:
        return self.send_to(self._clients[name], self._goal())

    def send_to(self, client: Any, goal: Any) -> Sent:
        """A goal of any type."""
        return Sent(self.executor, client, goal)

    def do(self, name: str) -> Any:
        """Have a goal succeed."""
        status, result = self.send(name).result()
        assert (status, result.outcome_name) == (4, "SUCCEEDED"), result.reason
        return result

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """The response of a service."""
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(PATIENCE_S), name
        future = client.call_async(request)
        wait_until(f"{name} answered", future.done)
        self.node.destroy_client(client)
        return future.result()

    def put_down(self) -> None:
        """Whatever a test left: nothing is held, and nothing runs."""
        self.choose("nominal")
        wait_until("nothing is executed", lambda: self.state.command == -1)
        wait_until("the sensors are heard", lambda: self.state.link_up and not self.state.stale)
        if self.state.state != EndEffectorState.STAND_BY:
            self.do("Drop")
        wait_until("the tool changer is known", lambda: self.state.tool_changer_name != "UNKNOWN")
        if self.state.tool_changer_name != "LOCKED":
            self.do("LockToolChanger")
        # a grip is refused while anything is not proven to be gone (IL-07)
        wait_until("all is gone", lambda: set(self.state.evidence_names) == {"GONE"})

    def choose(self, bench: str) -> None:
        """What the testbench plays from now on."""
        self.world.choose(bench)


def with_stroke(tool: Description) -> Description:
    """The same tool, whose cylinder moves a joint."""
    cylinder = tool.actuators["cylinder"].model_copy(update={"stroke_mm": STROKE_MM})
    return tool.model_copy(update={"actuators": {**tool.actuators, "cylinder": cylinder}})


@pytest.fixture(scope="session", params=[ONE, FIVE], ids=["one", "five"])
def running(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[System]:
    """The nodes in one process, then in five."""
    folder = tmp_path_factory.mktemp("ros2")
    with World(with_stroke(load(profile_path())), "nominal", folder) as world:
        system = System(world, folder, request.param)
        system.start_nodes()
        system.join()
        system.connect()
        yield system
        system.close()


@pytest.fixture
def system(running: System) -> Iterator[System]:
    """Standing by before a test, and after it."""
    running.put_down()
    yield running
    running.put_down()


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package of programs and launch files, where colcon installs it; run in the workspace, as a user does."""
    space = tmp_path_factory.mktemp("ws")
    (space / "src").mkdir()
    (space / "src" / PACKAGE.name).symlink_to(PACKAGE)
    env = {"ROS_VERSION": "2", "ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": sys.prefix}
    done = subprocess.run(
        [Path(sys.executable).with_name("colcon"), "build"], cwd=space, env={**os.environ, **env},
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return space / "install" / PACKAGE.name
