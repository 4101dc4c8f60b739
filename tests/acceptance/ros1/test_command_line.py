"""rostopic, rosservice, rosbag and rosnode work as a ROS user expects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.interface import COMMAND_ACTIONS, services, topics
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros


def test_rostopic_echo_shows_the_latched_state(system: Any) -> None:
    shown = system.cli("rostopic", "echo", "-n1", "/EndEffectorState")
    assert shown.returncode == 0
    assert "\nstate: 6\n" in shown.stdout
    assert "actuator_names: \n  - bottom_vacuum" in shown.stdout.replace(
        "actuator_names:\n", "actuator_names: \n"
    )


def test_rosservice_call_drives_an_actuator_and_proves_it(system: Any) -> None:
    done = system.cli("rosservice", "call", "/SetBottomVacuum", "data: true")
    try:
        assert (done.returncode, done.stderr) == (0, "")
        assert "success: True" in done.stdout
        assert "sensor" in done.stdout
        assert system.edges()[-1] == ("SODIMM_208", 1)
    finally:
        done = system.cli("rosservice", "call", "/SetBottomVacuum", "data: false")
    assert "success: True" in done.stdout
    assert system.edges()[-1] == ("SODIMM_208", 0)


def test_rosmsg_and_rossrv_show_every_type_of_the_interface(system: Any) -> None:
    """Debian has the definitions of messages in packages of their own, apart from their Python modules."""
    tool = load(profile_path())
    types = {("rosmsg", topic.type) for topic in topics(tool)}
    types |= {("rosmsg", f"{action.type}Action") for action in COMMAND_ACTIONS}
    types |= {("rossrv", service.type) for service in services(tool)}
    shown = {kind: system.cli(kind[0], "show", kind[1]) for kind in sorted(types)}
    assert {kind: done.stderr for kind, done in shown.items() if done.returncode or not done.stdout} == {}


def test_rosbag_records_and_plays_back_the_types(system: Any, tmp_path: Path) -> None:
    bag = tmp_path / "run.bag"
    done = system.cli(
        "rosbag", "record", "-O", str(bag), "--duration=2", "/EndEffectorState", "/PressureSupply"
    )
    assert done.returncode == 0, done.stderr
    told = system.cli("rosbag", "info", str(bag)).stdout
    assert "end_effector_msgs/EndEffectorState" in told
    assert "sensor_msgs/FluidPressure" in told


def test_rosnode_kill_while_gripped_changes_no_line_and_the_next_one_adopts(system: Any) -> None:
    system.grip()
    edges = system.edges()
    assert edges[-3:] == [("SODIMM_208", 1), ("SODIMM_210", 1), ("SODIMM_212", 1)]
    begun = len(system.states)
    killed = system.cli("rosnode", "kill", "/HALMain")
    assert killed.returncode == 0, killed.stderr
    system.until(
        "OFF, then GRIPPED", lambda: _visited(system, begun, EndEffectorState.OFF, EndEffectorState.GRIPPED)
    )
    assert system.edges() == edges
    assert system.state.held
    assert system.state.lift_allowed
    status, result = system.run("Drop")
    assert (status, result.state) == (3, EndEffectorState.STAND_BY)


def _visited(system: Any, begun: int, *states: EndEffectorState) -> bool:
    seen = [message.state for message in system.states[begun:]]
    return states[0] in seen and states[-1] in seen[seen.index(states[0]) :]
