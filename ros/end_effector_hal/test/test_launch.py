"""What `colcon test` runs: the launch files, with the testbench in place of hardware, and an action client."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

LAUNCH = ("ros2", "launch", "end_effector_hal")
LONGEST_S = 60.0


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
        (("end_effector.launch.py",), "No tool is named: exactly one is driven"),
        (("end_effector.launch.py", "description:=no_such.yaml"), "there is no such file"),
        (("several.launch.py", "tools:=left"), "are no tools"),
        (("several.launch.py", "tools:=a=x.yaml a=y.yaml"), "two tools in one namespace"),
    ],
)
def test_a_launch_without_a_tool_says_so_and_starts_nothing(arguments, sentence):
    assert sentence in refused(*arguments)


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
    log = tmp_path / "log"
    with log.open("w", encoding="utf-8") as output:
        launch = subprocess.Popen(
            [*LAUNCH, *arguments, "simulated:=true"],
            stdout=output, stderr=output, env={**os.environ, "PYTHONUNBUFFERED": "1"}, start_new_session=True,
        )  # fmt: skip
        try:
            for namespace in namespaces:
                assert gripped(namespace) == [("TriggerGrip", "SUCCEEDED"), ("Drop", "SUCCEEDED")], (
                    log.read_text()
                )
        finally:
            # as the terminal does with Ctrl-C
            os.killpg(launch.pid, signal.SIGINT)
            code = launch.wait(LONGEST_S)
    said = log.read_text()
    assert code == 0, said
    started = re.findall(r"\[(\w+)-\d+\]: process started", said)
    assert started.count("testbench") == started.count("arbiter") == len(namespaces)
    assert len(started) == 2 * len(namespaces) + programs
    # the testbench has no end in order; the others may not be ended by the second SIGINT
    assert set(re.findall(r"\[(\w+)-\d+\]: process has died", said)) <= {"testbench"}, said


def gripped(namespace):
    """Have the tool grip and drop; the outcomes."""
    import rclpy
    from end_effector_msgs.action import EndEffector
    from end_effector_msgs.msg import EndEffectorState
    from rclpy.action import ActionClient
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node
    from rclpy.qos import DurabilityPolicy, QoSProfile

    context = Context()
    rclpy.init(context=context)
    node = Node("client", namespace=namespace, context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    states = []
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(EndEffectorState, "EndEffectorState", states.append, latched)

    def ready():
        return states and (states[-1].state_name, states[-1].tool_changer_name) == ("STAND_BY", "LOCKED")

    def done(future):
        executor.spin_until_future_complete(future, LONGEST_S)
        return future.result()

    outcomes = []
    try:
        end = time.monotonic() + LONGEST_S
        while not ready() and time.monotonic() < end:
            executor.spin_once(0.2)
        for name in ("TriggerGrip", "Drop"):
            client = ActionClient(node, EndEffector, name)
            assert client.wait_for_server(LONGEST_S), name
            goal = done(client.send_goal_async(EndEffector.Goal()))
            outcomes.append((name, done(goal.get_result_async()).result.outcome_name))
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()
    return outcomes


def test_a_program_runs_in_an_environment_that_has_the_code():
    program = Path(__file__).parents[1] / "scripts" / "hal"
    done = subprocess.run([program], capture_output=True, text=True, timeout=LONGEST_S, check=False)
    assert (done.returncode, done.stderr.startswith("hal: No tool is named")) == (2, True), done.stderr
