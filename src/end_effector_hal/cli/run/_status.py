"""``eehal status``: the state of a tool that another process runs."""

from __future__ import annotations

import threading
from pathlib import Path

import click

from end_effector_hal.cli._options import PathName, end_in_order


@click.command("status")
@click.argument("description", type=PathName())
@click.option("--follow", is_flag=True, help="Also print every later change, until Ctrl-C.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(description: Path, follow: bool, as_json: bool) -> None:
    """Print the state of the tool of a DESCRIPTION, the evidence of its actuators, and its alarms.

    `eehal serve`, `eehal run` or the ROS nodes must run the tool.

    Exit codes: 0 printed, 2 the description has a fault, 3 no HAL runs the tool.
    """
    from end_effector_hal.runtime import EndEffector

    from ._voices import Changes, JsonLines, Words

    voice = JsonLines() if as_json else Words()
    end_in_order()
    with EndEffector.connect(description) as tool:
        status = tool.status
        voice.status(tool.description, status)
        if follow:
            changes = Changes(tool.description, voice)
            changes.begin(status)
            tool.subscribe(changes.status)
            threading.Event().wait()
