"""``eehal stop``: latches a stop of a tool from any terminal, independent of the program that runs the tool."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli._json_output import print_document
from end_effector_hal.cli._options import PathName


@click.command("stop")
@click.argument("description", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def command(description: Path, as_json: bool) -> None:
    """Latch a stop of the tool of a DESCRIPTION: nothing is activated until a reset. It is not a safety function.

    The line arbiter latches the stop like an open e-stop (IL-13), also through a restart, and refuses every activation
    from then on. A program that executes a grip cancels it within half a second, and does what the description
    declares for a cancel (`endings`); a held part stays held. `eehal reset` ends the stop, and so does a reset at the
    prompt, through ROS or on the page.

    Exit codes: 0 the stop is latched, 3 the line arbiter cannot be reached.
    """
    from end_effector_hal.arbiter import ArbiterClient
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import socket_path
    from end_effector_hal.runtime import latch_stop

    with ArbiterClient(socket_path(load_tool(description)), "eehal stop", patience_s=0) as arbiter:
        what = latch_stop(arbiter)
    if as_json:
        print_document({"ok": True, "stopped": True, "reason": what})
    else:
        click.echo(f"{what} To end the stop: eehal reset {description}")
