"""The table names what the paper names, for any tool; it needs no ROS."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.nodes.interface import (
    ACTIONS,
    COMMAND_ACTIONS,
    position_topics,
    pressure_topics,
    services,
    set_tool_changer,
    topics,
)
from end_effector_hal.vocabulary import Command


@pytest.fixture
def tool() -> Description:
    return load(profile_path())


def test_the_services_and_topics_of_table_i(tool: Description) -> None:
    assert [service.name for service in services(tool)] == [
        "SetBottomVacuum",
        "SetCylinder",
        "SetTopVacuum",
        "SetToolChanger",
        "ArmToolChanger",
        "ResumeGrip",
        "StopTool",
        "ResetFaults",
    ]
    assert [(channel, topic.name) for channel, topic in pressure_topics(tool)] == [
        ("bottom", "PressureVacuumBottom"),
        ("cylinder", "PressureCylinder"),
        ("top", "PressureVacuumTop"),
        ("supply", "PressureSupply"),
    ]
    assert {name: topic.name for name, topic in position_topics(tool).items()} == {
        "cylinder": "PositionCylinder"
    }


def test_each_action_gives_one_command() -> None:
    assert {action.name: action.command for action in COMMAND_ACTIONS} == {
        "LockToolChanger": Command.LOCK,
        "UnlockToolChanger": Command.UNLOCK,
        "TriggerGrip": Command.GRIP,
        "Drop": Command.RELEASE,
    }


def test_names_are_relative_and_stand_there_once(tool: Description) -> None:
    names = [entity.name for entity in (*topics(tool), *services(tool), *ACTIONS)]
    assert len(names) == len(set(names))
    assert [name for name in names if name.startswith("/")] == ["/diagnostics"]


def test_nothing_of_ros_is_a_sensor_or_a_status_of_the_hal(tool: Description) -> None:
    """Only those who write it down, or wait for their own goals, subscribe to anything."""
    heard = {topic.name: topic.subscribers for topic in topics(tool) if topic.subscribers}
    assert heard == {
        "EndEffectorState": ("DataLogger", "Supervisor"),
        "supervisor_commands": ("DataLogger",),
    }


def test_a_tool_without_a_changer_has_none_of_its_names(tool: Description) -> None:
    fixed = tool.model_copy(update={"tool_changer": None})
    assert set_tool_changer(fixed) is None
    assert "SetToolChanger" not in {service.name for service in services(fixed)}
    assert "PositionToolChanger" not in {topic.name for topic in topics(fixed)}


def test_the_table_is_read_without_ros() -> None:
    code = "import sys; import end_effector_hal.nodes.interface; sys.exit(int('rospy' in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=Path.home()).returncode == 0
