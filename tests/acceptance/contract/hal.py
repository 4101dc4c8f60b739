"""A running HAL in either generation of ROS: its processes, its world, and the driver that looks at it from outside."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros import PROGRAM, Master, apart
from end_effector_lab.demo._world import World
from end_effector_lab.processes import Child
from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.driver import Driver, Goal, Heard, Message
from tests.support.patience import wait_until
from tests.support.places import ROOT
from tests.support.stopped import stop

T = TypeVar("T")
GENERATION = 2 if importlib.util.find_spec("rclpy") else 1 if importlib.util.find_spec("rospy") else 0
"""Of ROS, in this environment; 0: there is none."""
LAYOUTS: Mapping[int, Sequence[str]] = {1: ("five",), 2: ("one", "five")}
"""Processes of the HAL: one for each node, as the paper draws it, or one for all."""

PROGRAMS = {
    "Pressure": "pressure", "Position": "position", "Grip": "grip", "ToolChange": "tool_change", "HALMain": "hal_main",
}  # fmt: skip
NODES = tuple(PROGRAMS)
ACTION = "end_effector_msgs/EndEffector"
START_S = 90.0
SETTLED = ("STAND_BY", "GRIPPED", "GRIP_ERROR", "RELEASE_ERROR")
STROKE_MM = 80.0
"""Of the cylinder: the description of the paper's tool has none."""


def quick() -> Description:
    """The shipped tool with a stroke, and with shorter time-outs: still many times what a confirmation takes."""
    tool = load(profile_path())
    shorter = {"timeout_s": 2.5, "reset_s": 0.3, "attempts": 2}
    actuators = {name: actuator.model_copy(update=shorter) for name, actuator in tool.actuators.items()}
    actuators["cylinder"] = actuators["cylinder"].model_copy(update={"stroke_mm": STROKE_MM})
    return tool.model_copy(update={"actuators": actuators})


class Ros:
    """What processes of one generation need to hear each other and nobody else, and how its programs are called."""

    def __init__(self, world: World, folder: Path) -> None:
        self.generation = GENERATION
        if self.generation == 1:
            master = Master(folder / "ros")
            self.env = dict(master.env)
            master.start(world.children, folder / "roscore.log", patience_s=START_S)
        else:
            self.env = {**apart(folder / "ros"), "ROS_PYTHON_CHECK_FIELDS": "1"}

    def command(
        self, program: str, namespace: str, parameters: Mapping[str, object], name: str = ""
    ) -> list[str]:
        """A program with parameters, in a namespace."""
        if self.generation == 1:
            named = [f"__name:={name}"] if name else []
            given = [f"_{key}:={value}" for key, value in parameters.items()]
            script = ROOT / "ros/end_effector_hal/scripts" / program
            return [sys.executable, str(script), *given, *named, f"__ns:={namespace or '/'}"]
        given = [word for key, value in parameters.items() for word in ("-p", f"{key}:={value}")]
        named = ["-r", f"__node:={name}"] if name else []
        return [*PROGRAM, program, "--ros-args", *given, *named, "-r", f"__ns:={namespace or '/'}"]


@dataclass
class Hal:
    """The nodes of one tool.

    Attributes:
        world: lines, line arbiter and testbench.
        ros: its graph.
        layout: of its processes.
        driver: sees it.
        namespace: of its nodes, such as ``/left``; empty: the root.
        states: every EndEffectorState so far.
    """

    world: World
    ros: Ros
    layout: str
    driver: Driver
    namespace: str = ""
    parameters: Mapping[str, object] = field(default_factory=dict)
    states: Heard = field(default_factory=Heard)
    children: dict[str, Child] = field(default_factory=dict)
    _numbers: list[int] = field(default_factory=list)

    until = staticmethod(wait_until)

    # Its processes.

    @property
    def one(self) -> bool:
        """Whether all nodes are in one process."""
        return self.layout == "one"

    def program(self, node: str) -> str:
        """The program that runs a node."""
        return "hal" if self.one else PROGRAMS[node]

    def start(self, node: str) -> None:
        """Start the program of a node."""
        program = self.program(node)
        self.children[program] = self.begin(program, "", **self.parameters)

    def begin(self, program: str, name: str = "", **parameters: object) -> Child:
        """A program with the tool of this world."""
        given = {"description": self.world.description_path.absolute(), **parameters}
        return self.begin_bare(program, name, **{key: value for key, value in given.items() if value != ""})

    def begin_bare(self, program: str, name: str = "", **parameters: object) -> Child:
        """A program with these parameters and no others."""
        self._numbers.append(0)
        return self.world.children.start(
            program, self.ros.command(program, self.namespace, parameters, name),
            log=self.world.folder / f"{program}-{len(self._numbers)}.log", failed=RosError, env=self.ros.env,
            end_by=signal.SIGINT, patience_s=20.0,
        )  # fmt: skip

    def start_all(self) -> None:
        """Start every program that does not run."""
        for node in NODES:
            child = self.children.get(self.program(node))
            if child is None or child.code is not None:
                self.start(node)

    def end_all(self) -> None:
        """End every program, all at once: each takes a second or more to leave the graph."""
        running = [child for child in self.children.values() if child.code is None]
        for child in running:
            os.kill(child.pid, signal.SIGINT)
        for child in running:
            child.wait_for_end(timeout_s=60.0)

    def kill(self, node: str, number: int = signal.SIGKILL) -> int:
        """End the program of a node by a signal; its exit code."""
        child = self.children[self.program(node)]
        os.kill(child.pid, number)
        return child.wait_for_end(timeout_s=60.0)

    def signal(self, node: str, number: int) -> None:
        """Send a signal to the program of a node."""
        os.kill(self.children[self.program(node)].pid, number)

    def stop(self, node: str) -> None:
        """Have the program of a node stand still."""
        stop(self.children[self.program(node)].pid)

    def said(self, node: str) -> str:
        """The log of the program of a node."""
        return self.children[self.program(node)].text()

    def connect(self) -> None:
        """Hear the state, and wait until the tool stands by and its actions are served."""
        self.states = self.driver.subscribe(
            self.full("EndEffectorState"), "end_effector_msgs/EndEffectorState"
        )
        self.serve()
        self.rest()

    def serve(self) -> None:
        """Wait until every action is served."""
        for action in ("LockToolChanger", "UnlockToolChanger", "TriggerGrip", "Drop"):
            name = self.full(action)
            wait_until(f"a server of {action}", partial(self.driver.ask, "served", action=name, kind=ACTION))

    def full(self, name: str) -> str:
        """The full name of something of this tool."""
        return name if name.startswith("/") else f"{self.namespace}/{name}"

    # What it says.

    @property
    def state(self) -> Message:
        """The newest state."""
        return self.states.newest

    @property
    def since(self) -> int:
        """How many states have come."""
        return len(self.states.messages)

    def after(self, count: int) -> list[Message]:
        """The states that have come since then."""
        return self.states.messages[count:]

    def wait_for(self, *names: str) -> Message:
        """The newest state, once it is one of these and nothing is executed."""
        wait_until(
            " or ".join(names),
            lambda: (
                self.states.messages
                and self.state["state_name"] in names
                and self.state["command_name"] == "NONE"
            ),
        )
        return self.state

    def sees(self, what: str, ready: Callable[[Message], T]) -> Message:
        """The first state from now on, the newest one included, that is as wanted."""
        begun = max(0, self.since - 1)

        def found() -> Message | None:
            return next((each for each in self.after(begun) if ready(each)), None)

        return wait_until(what, found) or {}

    def alarmed(self, *words: str) -> bool:
        """Whether an alarm has all these words."""
        return any(all(word in alarm for word in words) for alarm in self.state["alarms"])

    def edges(self) -> list[tuple[str, int]]:
        """Every write to the lines so far, from the log of the virtual chip."""
        records = [json.loads(line) for line in self.world.chip.read_text().splitlines() if line.strip()]
        return [(record["line"], record["level"]) for record in records if "line" in record]

    # What it is asked.

    def send(self, action: str, **goal: object) -> Goal:
        """A goal of one of the four actions, with these fields."""
        return self.driver.send(self.full(action), ACTION, goal)

    def begin_goal(self, action: str, what: str, ready: Callable[[Message], object]) -> Goal:
        """Send a goal, and wait for a state in which it runs."""
        begun = self.since
        goal = self.send(action)
        wait_until(what, lambda: goal.ends or any(map(ready, self.after(begun))))
        assert goal.ends == [], f"it ended before {what}: {goal.ends}"
        return goal

    def do(self, action: str, **goal: object) -> Message:
        """Have a goal succeed; its result."""
        status, result = self.send(action, **goal).end()
        assert (status, result["outcome_name"]) == ("SUCCEEDED", "SUCCEEDED"), result
        return result

    def refused(self, action: str, **goal: object) -> str:
        """Why a goal is refused: with the status that a refusal has in this generation."""
        status, result = self.send(action, **goal).end()
        assert (status, result["outcome_name"]) == (
            self.by(Difference.REFUSED_GOAL, ros1="REJECTED", ros2="ABORTED"),
            "REJECTED",
        ), (
            status,
            result,
        )
        assert (result["seconds"], result["steps"]) == (0.0, [])
        return str(result["reason"])

    def call(self, service: str, **request: object) -> tuple[bool, str]:
        """The answer of a service of ``std_srvs``."""
        kind = "std_srvs/SetBool" if request else "std_srvs/Trigger"
        response = self.driver.call(self.full(service), kind, **request)
        return response["success"], response["message"]

    def choose(self, bench: str) -> None:
        """What the testbench plays from now on."""
        self.world.choose(bench)

    def by(self, difference: Difference, *, ros1: T, ros2: T) -> T:
        """What is expected in this generation; the row of the table that allows the difference."""
        assert isinstance(difference, Difference)
        return ros1 if self.ros.generation == 1 else ros2

    # Where it is to be before a check.

    def rest(self) -> None:
        """Nothing is held, nothing is wrong, the tool is locked."""
        self._settle()
        if self.state["state_name"] != "STAND_BY":
            wait_until("a drop", partial(self._succeeds, "Drop"))
        wait_until(
            "the tool changer", lambda: self.state["tool_changer_name"] in ("LOCKED", "UNLOCKED", "FAULT")
        )
        if self.state["tool_changer_name"] == "FAULT":
            wait_until("a reset", lambda: self.call("ResetFaults")[0])
            wait_until("no fault", lambda: self.state["tool_changer_name"] != "FAULT")
        if self.state["tool_changer_name"] != "LOCKED":
            wait_until("a lock", partial(self._succeeds, "LockToolChanger"))
        # a grip is refused while anything is not proven to be gone (IL-07), and a vacuum may still grow for a moment
        wait_until("rest", lambda: all(map(is_rest, self.states.messages[-4:])))

    def hold(self) -> None:
        """A part is held, and nothing is wrong."""
        self._settle()
        if self.state["state_name"] != "GRIPPED":
            wait_until("a grip", self._grips)
        wait_until("a part is held", lambda: all(map(is_hold, self.states.messages[-4:])))

    def _grips(self) -> bool:
        self.rest()
        return self._succeeds("TriggerGrip")

    def _succeeds(self, action: str) -> bool:
        """On a busy machine a command is too late, or a reading is stale: then it is given again."""
        return bool(self.send(action).end()[1]["outcome_name"] == "SUCCEEDED")

    def _settle(self) -> None:
        self.choose("nominal")
        self.wait_for(*SETTLED)
        wait_until("the sensors", lambda: self.state["link_up"] and not self.state["stale"])
        self.wait_for(*SETTLED)


def is_hold(state: Message) -> bool:
    """Whether a part is held, with fresh evidence, and the tool is locked."""
    names = (state["state_name"], state["command_name"], state["tool_changer_name"])
    return names == ("GRIPPED", "NONE", "LOCKED") and bool(state["lift_allowed"])


def is_rest(state: Message) -> bool:
    """Whether nothing is held and the tool is locked in its stand."""
    names = (state["state_name"], state["command_name"], state["tool_changer_name"], state["tool_stand_name"])
    return (
        names == ("STAND_BY", "NONE", "LOCKED", "IN_STAND")
        and state["evidence_names"] == ["GONE"] * 3
        and not state["unlock_output"]
    )
