"""A description cannot have names that the nodes use themselves; it needs no ROS."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.cli._check import check
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import DescriptionError
from end_effector_hal.nodes.interface import ACTIONS, NODES, load_for_nodes, name_faults, services, topics

SHIPPED = profile_path().read_text(encoding="utf-8")
TOPIC, SERVICE = "topic: PressureCylinder", "service: SetCylinder"


def faults(path: Path, *changes: tuple[str, str]) -> list[str]:
    text = SHIPPED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return [str(each).removeprefix(f"{path}:") for each in check(path).faults]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (SERVICE, "service: StopTool", "38:14: service 'StopTool' belongs to the nodes"),
        (SERVICE, "service: ArmToolChanger", "38:14: service 'ArmToolChanger' belongs to the nodes"),
        (SERVICE, "service: Grip/get_loggers", "38:14: service 'Grip/get_loggers' belongs to the nodes"),
        ("service: SetToolChanger", "service: Drop", "55:12: service 'Drop' belongs to the nodes"),
        (TOPIC, "topic: EndEffectorState", "39:12: topic 'EndEffectorState' belongs to the nodes"),
        (TOPIC, "topic: TriggerGrip/goal", "39:12: topic 'TriggerGrip/goal' belongs to the nodes"),
        (TOPIC, "topic: PressureSupply", "39:12: topic 'PressureSupply' belongs to the nodes"),
        (TOPIC, "topic: diagnostics", "39:12: topic 'diagnostics' belongs to the nodes"),
        (TOPIC, "topic: rosout", "39:12: topic 'rosout' belongs to the nodes"),
        (
            TOPIC,
            "topic: left/EndEffectorState",
            "39:12: topic 'left/EndEffectorState' belongs to the nodes of a tool in the namespace 'left'",
        ),
        (TOPIC, "topic: SetTopVacuum", "48:14: service 'SetTopVacuum' is the topic of cylinder already"),
        (TOPIC, "topic: PositionCylinder", "34:5: position topic 'PositionCylinder' is the topic of cylinder already"),
    ],
)  # fmt: skip
def test_a_name_of_the_nodes_is_refused_with_its_place(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    (found,) = faults(tmp_path / "tool.yaml", (old, new))
    assert found.startswith(sentence), found
    assert found.endswith(" [EE-221]")
    with pytest.raises(DescriptionError, match="EE-221"):
        load_for_nodes(tmp_path / "tool.yaml")


def test_a_name_that_is_made_of_an_actuators_name_is_refused_too(tmp_path: Path) -> None:
    changes = ("  cylinder:\n", "  tool_stand:\n"), ("vacuum, cylinder,", "vacuum, tool_stand,")
    (found,) = faults(tmp_path / "tool.yaml", *changes)
    assert found.startswith("34:5: position topic 'PositionToolStand' belongs to the nodes")


def test_an_absolute_spelling_is_no_name(tmp_path: Path) -> None:
    (found,) = faults(tmp_path / "tool.yaml", (SERVICE, "service: /grip/it"))
    assert "is not a name (/grip/it)" in found


def test_two_faults_are_told_at_once(tmp_path: Path) -> None:
    found = faults(tmp_path / "tool.yaml", (SERVICE, "service: ResetFaults"), (TOPIC, "topic: joint_states"))
    assert [line.split(": ")[0] for line in found] == ["38:14", "39:12"]


@pytest.mark.parametrize("name", ["grip/state", "Gripper", "my/GripState", "sensor_frame", "DropZone"])
def test_a_name_that_is_near_is_allowed(tmp_path: Path, name: str) -> None:
    assert faults(tmp_path / "tool.yaml", (TOPIC, f"topic: {name}")) == []


def test_nothing_of_the_table_can_be_taken() -> None:
    """Whatever the table names for a tool, but its own names, which are refused as a second use."""
    tool = load(profile_path())
    names = {each.name.lstrip("/") for each in (*topics(tool), *services(tool), *ACTIONS)} | set(NODES)
    own = {"PressureCylinder", "SetCylinder"}
    for name in names - own:
        cylinder = tool.actuators["cylinder"].model_copy(update={"topic": name})
        taken = tool.model_copy(update={"actuators": {**tool.actuators, "cylinder": cylinder}})
        assert [each.code for each in name_faults(taken)] == ["EE-221"], name


def test_the_shipped_tool_has_no_such_fault() -> None:
    assert name_faults(load(profile_path())) == ()
