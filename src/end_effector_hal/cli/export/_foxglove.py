"""A layout for Foxglove, or Lichtblick, with the topics of the tool: states, pressures, reasons, log and
diagnostics.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from end_effector_hal.cli._options import PathName, write_or_print
from end_effector_hal.description import Description, profile_path
from end_effector_hal.kinds.stanza import NO_CHANNEL
from end_effector_hal.nodes.interface import (
    DIAGNOSTICS,
    END_EFFECTOR_STATE,
    Topic,
    load_for_nodes,
    pressure_topics,
)
from end_effector_hal.vocabulary import display_name

GREEN, GREY, RED = "#009e73", "#9e9e9e", "#d55e00"  # told apart by colour-blind people


@click.command(name="foxglove", short_help="A layout for Foxglove with the topics of the tool.")
@click.argument("file", type=PathName(), required=False)
@click.option("--namespace", metavar="NS", default="", help="ROS namespace of the tool, such as /left.")
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_foxglove(file: Path | None, namespace: str, output: Path | None) -> None:
    """Write a Foxglove layout for the tool of the description FILE; default: the shipped one.

    Import it with "Import from file…" and connect to the robot by foxglove_bridge, or open a bag. The layout only
    shows the tool and sends no command.
    """
    description = load_for_nodes(file or profile_path())
    write_or_print(output, foxglove_layout(description, namespace), description.files)


def foxglove_layout(description: Description, namespace: str = "") -> str:
    """Return the layout as JSON; the same description gives the same text."""
    panels = dict(_panels(description, namespace))
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split(
            "row",
            _split("column", "StateTransitions!states", "Plot!pressures", 45),
            _split(
                "column",
                _split("row", "Indicator!held", "Indicator!lift", 50),
                _split(
                    "column",
                    "RawMessages!reason",
                    _split("column", "DiagnosticSummary!health", "RosOut!log", 40),
                    25,
                ),
                15,
            ),
            65,
        ),
    }
    return json.dumps(layout, indent=2, ensure_ascii=False) + "\n"


def _panels(description: Description, namespace: str) -> Iterator[tuple[str, dict[str, Any]]]:
    state = _name(END_EFFECTOR_STATE, namespace)
    states = {f"{state}.state_name": "End-effector", f"{state}.command_name": "Command"}
    for index, name in enumerate(description.sequence):
        states[f"{state}.actuator_states[{index}]"] = display_name(name)
    if description.tool_changer is not None:
        states[f"{state}.tool_changer_name"] = "Tool changer"
    yield "StateTransitions!states", {"paths": _paths(states), "isSynced": True}
    pressures = {
        f"{_name(topic, namespace)}.fluid_pressure": f"{topic.name} (Pa, absolute)"
        for channel, topic in pressure_topics(description)
        if channel != NO_CHANNEL
    }
    yield "Plot!pressures", {
        "paths": _paths(pressures), "showXAxisLabels": True, "showYAxisLabels": True, "showLegend": True,
        "legendDisplay": "floating", "isSynced": True, "xAxisVal": "timestamp", "sidebarDimension": 240,
    }  # fmt: skip
    yield "Indicator!held", _indicator(f"{state}.held", "HELD", "nothing held")
    yield "Indicator!lift", _indicator(f"{state}.lift_allowed", "LIFT ALLOWED", "no lift")
    yield "RawMessages!reason", {
        "topicPath": f"{state}.reason", "diffEnabled": False, "diffMethod": "custom", "diffTopicPath": "",
        "showFullMessageForDiff": False,
    }  # fmt: skip
    yield "DiagnosticSummary!health", {
        "minLevel": 0, "pinnedIds": [], "hardwareIdFilter": description.name,
        "topicToRender": DIAGNOSTICS.name, "sortByLevel": True,
    }  # fmt: skip
    yield "RosOut!log", {"topicToRender": "/rosout", "searchTerms": [], "minLogLevel": 2}


def _name(topic: Topic, namespace: str) -> str:
    return "/" + "/".join(filter(None, (namespace.strip("/"), topic.name)))


def _paths(labels: dict[str, str]) -> list[dict[str, object]]:
    return [
        {"value": value, "label": label, "enabled": True, "timestampMethod": "headerStamp"}
        for value, label in labels.items()
    ]


def _indicator(path: str, yes: str, no: str) -> dict[str, object]:
    rules = [
        {"operator": "=", "rawValue": raw, "color": color, "label": label}
        for raw, color, label in (("true", GREEN, yes), ("false", GREY, no))
    ]
    return {
        "path": path,
        "style": "background",
        "fallbackColor": RED,
        "fallbackLabel": "no news",
        "rules": rules,
    }


def _split(direction: str, first: object, second: object, percent: int) -> dict[str, object]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percent}
