"""``eehal export foxglove``: each panel stands in the layout, and each path leads to a field of a message of ours."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.interface import topics

ROOT = Path(__file__).parents[3]
MESSAGES = ROOT / "ros" / "end_effector_msgs" / "msg"
OF_ROS = {"sensor_msgs/FluidPressure": {"fluid_pressure": "float64"}}
TOOLS = [profile_path(), *sorted((ROOT / "examples" / "tools").glob("*/*.yaml"))]


def exported(*arguments: object) -> dict[str, Any]:
    result = CliRunner().invoke(eehal, ["export", "foxglove", *map(str, arguments)], catch_exceptions=False)
    layout: dict[str, Any] = json.loads(result.output)
    return layout


def placed(layout: object) -> Iterator[str]:
    if isinstance(layout, dict):
        yield from placed(layout["first"])
        yield from placed(layout["second"])
    else:
        yield str(layout)


def paths(layout: dict[str, Any]) -> Iterator[str]:
    for panel in layout["configById"].values():
        yield from (each["value"] for each in panel.get("paths", ()))
        yield from (panel[key] for key in ("path", "topicPath") if key in panel)


def fields(message: str) -> dict[str, str]:
    if message in OF_ROS:
        return OF_ROS[message]
    text = (MESSAGES / f"{message.partition('/')[2]}.msg").read_text()
    return {name: kind for kind, name in re.findall(r"^([\w/\[\]]+) +(\w+)\b(?!\s*=)", text, re.MULTILINE)}


@pytest.mark.parametrize("tool", TOOLS, ids=lambda path: path.parent.name)
def test_each_path_is_a_field_of_a_topic_of_the_tool(tool: Path) -> None:
    layout, description = exported(tool), load(tool)
    known = {f"/{topic.name}": topic.type for topic in topics(description)}
    for path in paths(layout):
        topic, _, field = path.partition(".")
        found = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", field)
        assert found, path
        kind = fields(known[topic])[found[1]]
        assert kind.endswith("[]") is (found[2] is not None), path
        assert found[2] is None or int(found[2]) < len(description.sequence)


def test_each_panel_has_its_place_and_a_namespace_stands_before_each_topic() -> None:
    layout = exported("--namespace", "/left")
    assert sorted(placed(layout["layout"])) == sorted(layout["configById"])
    assert all(path.startswith("/left/") for path in paths(layout))
    assert layout["configById"]["DiagnosticSummary!health"]["topicToRender"] == "/diagnostics"
