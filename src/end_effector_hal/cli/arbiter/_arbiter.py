"""``eehal arbiter``: the process that owns the output lines."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli._completion import completed, profiles
from end_effector_hal.cli._options import PathName
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import tool_path


@click.command()
@click.argument("description", type=PathName(), default=None, required=False)
@click.option(
    "--profile",
    default="",
    shell_complete=completed(profiles),
    help="Name of a shipped tool, instead of a description.",
)
@click.option("--socket", type=PathName(), help="Unix socket to serve; default: the description's.")
@click.option(
    "--journal",
    type=PathName(file_okay=False, exists=True),
    help="Folder that survives a loss of power; default: $STATE_DIRECTORY, else that of the socket.",
)
@click.option(
    "--group", help="Group whose members may command the lines; default: the group of this process."
)
def command(
    description: Path | None, profile: str, socket: Path | None, journal: Path | None, group: str | None
) -> None:
    """Own all output lines of a tool (in one request) and serve them on a Unix socket.

    The tool is named by its DESCRIPTION or by --profile; there is no default.

    Lines that are outputs already keep their level; inputs become inactive outputs. When a client dies, the arbiter
    executes its last will. The lines keep their level when the arbiter ends. The arbiter keeps latched faults in a
    journal, and last wills in the session record beside the socket, for the next arbiter.
    """
    from end_effector_hal.arbiter import run_arbiter

    path = tool_path(description or "", profile, how="DESCRIPTION or --profile NAME")
    run_arbiter(load_tool(path), socket, journal, group)
