"""What `colcon test` runs: the launch files, with the testbench in place of hardware, and clients of actions."""

import json
import os
import re
import signal
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

LAUNCH = ("ros2", "launch", "end_effector_hal")
LONGEST_S = 60.0
SUCCEEDED = 4
NOT_PROVEN = "IL-07"
"""Refuses a grip without proof that nothing is held; a machine that stands still loses it for a moment."""
CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 6


def refused(*arguments):
    """The last line of a launch that starts nothing."""
    done = subprocess.run(
        [*LAUNCH, *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LONGEST_S, check=False,
    )  # fmt: skip
    assert done.returncode == 1, done.stdout
    assert "process started" not in done.stdout
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("end_effector.launch.py",), "No tool is named: exactly one tool is needed"),
        (("end_effector.launch.py", "description:=no_such.yaml"), "there is no such file"),
        (("several.launch.py", "tools:=left"), "are no tools"),
        (("several.launch.py", "tools:=a=x.yaml a=y.yaml"), "two tools in one namespace"),
    ],
)
def test_a_launch_without_a_tool_says_so_and_starts_nothing(arguments, sentence):
    assert sentence in refused(*arguments)


@contextmanager
def launched(log, *arguments, code=0, **env):
    """A launch of simulated tools, and its end by Ctrl-C; yields a function that reads what was said."""
    with log.open("w", encoding="utf-8") as output:
        launch = subprocess.Popen(
            [*LAUNCH, *arguments, "simulated:=true"],
            stdout=output, stderr=output, env={**os.environ, "PYTHONUNBUFFERED": "1", **env}, start_new_session=True,
        )  # fmt: skip
    try:
        yield log.read_text
    finally:
        # as the terminal does with Ctrl-C
        os.killpg(launch.pid, signal.SIGINT)
        try:
            ended = launch.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            os.killpg(launch.pid, signal.SIGKILL)
            pytest.fail(f"it has not ended {LONGEST_S:g} s after Ctrl-C:\n{log.read_text()}")
    said = log.read_text()
    assert ended == code, said
    assert "escalating to" not in said, said
    # the testbench has no end in order; the others may not be ended by the second SIGINT
    assert set(re.findall(r"\[(\w+)-\d+\]: process has died", said)) <= {"testbench"}, said


GONE = 1
"""Of Evidence.msg."""


class Client:
    """An application of one tool."""

    def __init__(self, namespace):
        import rclpy
        from end_effector_msgs.action import EndEffector
        from end_effector_msgs.msg import EndEffectorState
        from rclpy.action import ActionClient
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self.context, self.states = Context(), []
        rclpy.init(context=self.context)
        self.node = Node("client", namespace=namespace, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(EndEffectorState, "EndEffectorState", self.states.append, latched)
        names = ("TriggerGrip", "Drop")
        self.actions = {name: ActionClient(self.node, EndEffector, name) for name in names}
        self.goal = EndEffector.Goal

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()

    def until(self, what, ready):
        """Hear until something is so."""
        end = time.monotonic() + LONGEST_S
        while not ready():
            assert time.monotonic() < end, f"not within {LONGEST_S:g} s: {what}"
            self.executor.spin_once(0.1)

    def until_state(self, name):
        """Wait for a state of a tool that is locked; at rest, until all is proven gone: a grip asks for it (IL-07)."""

        def reached():
            if not self.states:
                return False
            last = self.states[-1]
            proven = name != "STAND_BY" or {*last.evidence} == {GONE}
            return proven and (last.state_name, last.tool_changer_name) == (name, "LOCKED")

        self.until(name, reached)

    def done(self, future):
        """What is answered."""
        self.until("an answer", future.done)
        return future.result()

    def give(self, name):
        """Send a goal; what its end will be."""
        self.until(name, self.actions[name].server_is_ready)
        return self.done(self.actions[name].send_goal_async(self.goal())).get_result_async()

    def do(self, name):
        """Have a goal succeed."""
        self.succeeds(name, self.give(name))

    def succeeds(self, name, end):
        """Wait for the end of a goal; one that was refused because this machine stood still is given again."""
        ended = self.done(end)
        if NOT_PROVEN in ended.result.reason:
            self.until_state("STAND_BY")
            ended = self.done(self.give(name))
        assert (ended.status, ended.result.outcome_name) == (SUCCEEDED, "SUCCEEDED"), ended.result.reason


@pytest.mark.parametrize(
    ("arguments", "namespaces", "programs"),
    [
        (("end_effector.launch.py", "profile:=verdin_gripper"), [""], 1),
        (
            ("end_effector.launch.py", "profile:=verdin_gripper", "namespace:=cell", "processes:=five"),
            ["cell"],
            5,
        ),
        (("several.launch.py", "tools:=left=verdin_gripper right=verdin_gripper"), ["left", "right"], 2),
    ],
    ids=["one", "five", "several"],
)
def test_a_simulated_tool_grips_and_drops(tmp_path, arguments, namespaces, programs):
    with launched(tmp_path / "log", *arguments) as said:
        for namespace in namespaces:
            with Client(namespace) as client:
                client.until_state("STAND_BY")
                client.do("TriggerGrip")
                client.do("Drop")
    started = re.findall(r"\[(\w+)-\d+\]: process started", said())
    assert started.count("testbench") == started.count("arbiter") == len(namespaces)
    assert len(started) == 2 * len(namespaces) + programs


def writes(chip):
    """Every write to the lines of a simulated tool so far."""
    records = [json.loads(line) for line in chip.read_text().splitlines() if line.strip()]
    return [(record["line"], record["level"]) for record in records if "line" in record]


def test_two_tools_at_once_do_not_touch_each_other(tmp_path):
    """In five processes each: all that the nodes of a tool tell each other stands on the graph."""
    tools = ("several.launch.py", "tools:=left=verdin_gripper right=verdin_gripper", "processes:=five")
    with launched(tmp_path / "log", *tools) as said, Client("left") as left, Client("right") as right:
        for each in (left, right):
            each.until_state("STAND_BY")
        places = re.findall(r"simulated: (\S+)", said())
        left_chip, right_chip = (Path(place).with_name("chip") for place in places)
        quiet, since = writes(right_chip), len(right.states)

        left.do("TriggerGrip")
        left.until_state("GRIPPED")
        right.until("states of the right one", lambda: len(right.states) > since + 3)
        assert {each.state_name for each in right.states[since:]} == {"STAND_BY"}
        assert not any(any(each.outputs) for each in right.states[since:])
        assert writes(right_chip) == quiet

        # one grips while the other one drops
        dropped, gripped = left.give("Drop"), right.give("TriggerGrip")
        left.succeeds("Drop", dropped)
        right.succeeds("TriggerGrip", gripped)
        left.until_state("STAND_BY")
        right.until_state("GRIPPED")
        assert right.states[-1].held
        assert not left.states[-1].held

        held, since = writes(right_chip), len(right.states)
        left.do("TriggerGrip")
        left.do("Drop")
        right.until("states of the right one", lambda: len(right.states) > since + 3)
        assert all(each.held and each.lift_allowed for each in right.states[since:])
        assert writes(right_chip) == held
        assert len(writes(left_chip)) > len(writes(right_chip))
        right.do("Drop")


def test_a_managed_tool_is_proven_configured_activated_and_held(tmp_path):
    from lifecycle_msgs.srv import ChangeState, GetState

    arguments = ("end_effector.launch.py", "profile:=verdin_gripper", "namespace:=cell", "processes:=managed")
    state = {"XDG_STATE_HOME": str(tmp_path / "state")}
    with launched(tmp_path / "log", *arguments, **state) as said, Client("cell") as client:
        transitions = client.node.create_client(ChangeState, "EndEffector/change_state")
        states = client.node.create_client(GetState, "EndEffector/get_state")

        def answers():
            """A first answer of a service may find no way back yet."""
            future = states.call_async(GetState.Request())
            client.executor.spin_until_future_complete(future, 1.0)
            return future.done()

        client.until("the managed node", answers)
        client.until("the line arbiter", lambda: "ready: " in said())

        def change(transition):
            request = ChangeState.Request()
            request.transition.id = transition
            return client.done(transitions.call_async(request)).success

        (tool,) = re.findall(r"simulated: (\S+)", said())
        chip = Path(tool).with_name("chip")
        assert not change(CONFIGURE)
        client.until("the reason", lambda: "No proof is stored of verdin_gripper" in said())
        verify = ("ros2", "run", "end_effector_hal", "eehal", "verify", tool)
        subprocess.run(
            verify, env={**os.environ, **state}, capture_output=True, timeout=LONGEST_S, check=True
        )
        assert change(CONFIGURE)
        begun = writes(chip)
        assert not client.states
        assert change(ACTIVATE)
        client.until_state("STAND_BY")
        client.do("TriggerGrip")
        held = writes(chip)
        assert len(held) > len(begun)
        assert change(DEACTIVATE)
        assert change(CLEANUP)
        assert change(CONFIGURE)
        assert change(ACTIVATE)
        assert writes(chip) == held
        client.until_state("GRIPPED")
        client.do("Drop")
        assert change(DEACTIVATE)
        assert change(SHUTDOWN)
        started = r"\[lifecycle_hal-\d+\]: process started"
        client.until("another start", lambda: len(re.findall(started, said())) == 2)
        client.until("an unconfigured node", answers)
        assert change(CONFIGURE)


def test_a_program_runs_in_an_environment_that_has_the_code():
    program = Path(__file__).parents[1] / "scripts" / "hal"
    done = subprocess.run([program], capture_output=True, text=True, timeout=LONGEST_S, check=False)
    assert (done.returncode, done.stderr.startswith("hal: No tool is named")) == (2, True), done.stderr
