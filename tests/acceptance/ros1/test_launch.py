"""The launch file: which tool it drives, where, and when it refuses to."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._world import World
from tests.support.patience import PATIENCE_S
from tests.support.stopped import stop

pytestmark = pytest.mark.ros
LAUNCH = ("roslaunch", "end_effector_hal", "end_effector.launch")


def refused(system: Any, *arguments: str, cwd: Path | None = None) -> str:
    """What a launch says that starts nothing; the first line of it."""
    env = {**system.world.children.env, **system.env}
    # $PWD as a shell has it
    env |= {"ROS_MASTER_URI": f"http://127.0.0.1:{system.free_port()}", "PWD": str(cwd or Path.cwd())}
    done = subprocess.run(
        [*LAUNCH, *arguments],
        env=env,
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert "started with pid" not in done.stdout, "no node, no master"
    assert "Traceback" not in done.stderr
    return done.stderr.splitlines()[0]


NO_TOOL = (
    "end_effector.launch: No tool is named: exactly one tool is needed. Give description:=FILE or profile:=NAME "
    "(roslaunch ignores an argument that it does not know); shipped profiles: verdin_gripper."
)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), NO_TOOL),
        pytest.param(("descripton:=tool.yaml",), NO_TOOL, marks=pytest.mark.thinned),
        pytest.param(
            ("description:=tool.yaml", "profile:=verdin_gripper"),
            NO_TOOL.replace("No tool is named", "Two tools are named"),
            marks=pytest.mark.thinned,
        ),
        pytest.param(
            ("profile:=verdin_griper",),
            "end_effector.launch: no profile is named 'verdin_griper'. Shipped: verdin_gripper.",
            marks=pytest.mark.thinned,
        ),
    ],
)
def test_a_launch_without_one_tool_ends_with_one_sentence(
    system: Any, arguments: tuple[str, ...], sentence: str
) -> None:
    assert refused(system, *arguments) == sentence


def test_a_bad_description_ends_the_launch_with_its_faults(system: Any, tmp_path: Path) -> None:
    tool = tmp_path / "my tool.yaml"
    tool.write_text(profile_path().read_text().replace("timeout_s: 5.0", "timeout_s: 5 s"))
    line = refused(system, f"description:={tool}")
    assert line.startswith(f"end_effector.launch: {tool}:25:16: 'timeout_s' is of the wrong type")
    tool.write_text(profile_path().read_text().replace("service: SetCylinder", "service: StopTool"))
    line = refused(system, f"description:={tool}")
    assert line.startswith(f"end_effector.launch: {tool}:38:14: service 'StopTool' belongs to the nodes")


def test_a_relative_path_starts_where_roslaunch_is_called(system: Any, tmp_path: Path) -> None:
    line = refused(system, "description:=tool.yaml", cwd=tmp_path)
    assert line.startswith(f"end_effector.launch: {tmp_path}/tool.yaml: there is no such file")


def test_a_relative_path_is_refused_where_the_shell_is_somewhere_else(system: Any, tmp_path: Path) -> None:
    env = {**system.world.children.env, **system.env, "PWD": "/elsewhere"}
    done = subprocess.run(
        [*LAUNCH, "description:=tool.yaml"], env=env, cwd=tmp_path, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines()[0] == (
        f"end_effector.launch: The relative path tool.yaml means {tmp_path}/tool.yaml here, but $PWD leads to "
        "/elsewhere/tool.yaml. Give an absolute path."
    )


def test_the_line_arbiter_needs_a_tool(system: Any) -> None:
    child = system.start("no_tool", "rosrun", "end_effector_hal", "line_arbiter", "__ns:=nothing")
    assert child.wait_for_end(timeout_s=PATIENCE_S) == 2
    said = child.text().strip()
    assert said.startswith(
        "line_arbiter: No tool is named: exactly one tool is needed. Give _description:=FILE"
    ), said
    assert "\n" not in said


def test_an_argument_that_is_no_parameter_is_a_sentence(system: Any) -> None:
    tool = f"_description:={system.world.description_path}"
    child = system.start("bad", "rosrun", "end_effector_hal", "position", "__ns:=bad", tool, "_other:=[1")
    assert child.wait_for_end(timeout_s=PATIENCE_S) == 2
    assert child.text().startswith("position: invalid command-line parameters:")
    assert "Traceback" not in child.text()


@pytest.fixture
def second(system: Any, tmp_path: Path) -> Iterator[World]:
    """Another tool, with hardware of its own."""
    with World(load(profile_path()), "nominal", tmp_path) as world:
        yield world


def addresses(system: Any) -> dict[str, list[str]]:
    """Of each node, by its name, as rosnode tells them."""
    shown = system.cli("rosnode", "list", "-a").stdout.splitlines()
    return {line.split()[1]: line.split()[:1] for line in shown if len(line.split()) == 2}


def test_two_tools_run_side_by_side_with_two_launches(system: Any, second: World) -> None:
    import actionlib
    import rospy
    from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal, EndEffectorState

    states: list[Any] = []
    launch = system.launch(second, "ns:=cell", name="cell")
    try:
        subscriber = rospy.Subscriber("/cell/EndEffectorState", EndEffectorState, states.append)
        client = actionlib.SimpleActionClient("/cell/TriggerGrip", EndEffectorAction)
        assert client.wait_for_server(rospy.Duration(60))
        system.until("STAND_BY", lambda: states and states[-1].state == 6)
        assert client.send_goal_and_wait(EndEffectorGoal(), rospy.Duration(60)) == 3
        system.until("GRIPPED", lambda: states[-1].state == 3)
        assert system.state.state == 6, "the other tool has not moved"
        edges = second.chip.read_text()
        assert system.run("TriggerGrip")[0] == 3
        assert system.run("Drop")[0] == 3
        assert (states[-1].state, second.chip.read_text()) == (3, edges), "nor this one"
        # one that says that this machine stood still is over soon
        system.until("no alarm", lambda: not [*states[-1].alarms, *system.state.alarms])
        subscriber.unregister()
    finally:
        launch.end(signal_number=signal.SIGINT, patience_s=20.0)


def test_a_second_launch_does_not_end_the_nodes_of_the_first(system: Any, second: World) -> None:
    system.grip()
    before = addresses(system)
    launch = system.launch(second, name="second")
    try:
        said = rf"grip: A node /Grip runs already for {re.escape(str(system.world.description_path))} \(process \d+\)"
        system.until("the refusal, again", lambda: len(re.findall(said, launch.text())) >= 2)
    finally:
        launch.end(signal_number=signal.SIGINT, patience_s=20.0)
    assert "it is left alone. Give this tool a namespace (ns:=NAME)" in launch.text()
    after = addresses(system)
    assert {name: after.get(name) for name in before} == before
    assert (system.state.state, system.state.held) == (3, True)
    assert "new node registered with same name" not in (system.folder / "launch.log").read_text()


def test_a_node_that_hangs_is_not_ended_for_another_tool(system: Any, second: World) -> None:
    import rosgraph

    server: Any = rosgraph.Master("/tests")
    uri, pid = server.lookupNode("/Position"), node_pid("/Position")
    stop(pid)
    try:
        child = system.start(
            "other_position", "rosrun", "end_effector_hal", "position",
            f"_description:={second.description_path}",
        )  # fmt: skip
        assert child.wait_for_end(timeout_s=PATIENCE_S) == 3
        assert "(it does not answer): it is left alone." in child.text()
        assert server.lookupNode("/Position") == uri
    finally:
        os.kill(pid, signal.SIGCONT)


def node_pid(name: str) -> int:
    import rosgraph

    from end_effector_hal.ros1.master import ask_node

    return int(ask_node(rosgraph.Master("/tests").lookupNode(name), "getPid"))


def test_transitions_and_refusals_are_on_rosout_and_in_the_terminal(system: Any) -> None:
    import rospy
    from rosgraph_msgs.msg import Log

    heard: list[tuple[str, int, str]] = []
    subscriber = rospy.Subscriber(
        "/rosout",
        Log,
        lambda message: heard.append((message.name, message.level, message.msg)),
        queue_size=500,
    )
    system.until("rosout", lambda: subscriber.get_num_connections() >= 5)
    system.world.choose("fails-once:bottom_vacuum")
    system.grip()
    assert system.run("TriggerGrip")[0] == 5
    assert system.run("Drop")[0] == 3
    wanted = [
        ("/HALMain", "STAND_BY -> GRIPPING (GRIP)"),
        ("/HALMain", "Bottom vacuum was not confirmed within 3 s: attempt 1 of 3."),
        ("/HALMain", "GRIPPING -> GRIPPED"),
        (
            "/HALMain",
            "TriggerGrip: REJECTED. A grip is accepted in STAND_BY only; the end-effector is GRIPPED.",
        ),
        ("/HALMain", "GRIPPED -> RELEASING (RELEASE)"),
        ("/HALMain", "RELEASING -> STAND_BY"),
        ("/Position", "cylinder: BETWEEN -> EXTENDED"),
    ]
    for node, text in wanted:
        line = f"{node}: {text}"
        system.until(line, lambda node=node, line=line: (node, Log.INFO, line) in heard)
        begun = heard.index(
            ("/HALMain", Log.INFO, f"/HALMain: {wanted[0][1]}")
        )  # the drop before may be heard
        assert heard[begun:].count((node, Log.INFO, line)) == 1
        assert line in (system.folder / "launch.log").read_text()
    subscriber.unregister()
