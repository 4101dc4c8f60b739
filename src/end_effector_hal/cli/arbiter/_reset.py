"""``eehal reset``: clears the latched faults of the line arbiter from any terminal."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from end_effector_hal.cli._json_output import print_document
from end_effector_hal.cli._options import PathName


@click.command("reset")
@click.argument("description", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def command(description: Path, as_json: bool) -> None:
    """Clear what the line arbiter of a DESCRIPTION has latched: a stop, an e-stop that is closed again, other faults.

    A fault whose cause persists stays latched. Faults that a program latches itself (a sensor fault of the tool
    changer, an alarm about a held part) are cleared by a reset at the prompt, through ROS or on the page; GRIP_ERROR
    and RELEASE_ERROR need a Drop. A reset activates nothing.

    Exit codes: 0 the line arbiter has no latched fault left, 1 a fault stays, 3 the arbiter cannot be reached.
    """
    from end_effector_hal.arbiter import ArbiterClient
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import socket_path
    from end_effector_hal.errors import LineRefusedError

    stays = ""
    with ArbiterClient(socket_path(load_tool(description)), "eehal reset", patience_s=0) as arbiter:
        try:
            if left := arbiter.reset():
                stays = f"{' '.join(left.values())} Reset it at the prompt, through ROS or on the page."
        except LineRefusedError as error:
            stays = str(error)
    if as_json:
        print_document({"ok": not stays, "reason": stays})
    else:
        click.echo(stays or "The line arbiter has nothing latched any more.", err=bool(stays))
    sys.exit(1 if stays else 0)
