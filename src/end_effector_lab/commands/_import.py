"""``eehal import``: converts a ROS bag to a recording."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import click

from end_effector_hal.cli import PathName, Progress, completed, print_document, profiles


@click.command("import", short_help="turn a ROS bag into a recording")
@click.argument("bag", metavar="BAG", type=PathName())
@click.option("-o", "--output", metavar="FOLDER", type=PathName(), help="A new one; default: runs/NAME.")
@click.option(
    "--description", metavar="FILE", type=PathName(), help="Of the tool: its pressures and thresholds."
)
@click.option(
    "--profile",
    metavar="NAME",
    default="",
    shell_complete=completed(profiles),
    help="A shipped tool, instead of a description.",
)
@click.option("--namespace", metavar="NS", help="ROS namespace of the tool, where the bag has several.")
@click.option("--json", "as_json", is_flag=True, help="Print what was imported as JSON.")
def command(
    bag: Path,
    output: Path | None,
    description: Path | None,
    profile: str,
    namespace: str | None,
    as_json: bool,
) -> None:
    """Convert the states and pressures in BAG to a recording, as DataLogger would have written it.

    BAG is a .bag file of ROS 1, a folder of rosbag2 (MCAP or SQLite), or an .mcap file. Messages that cannot be read
    are listed, and the rest is imported. A damaged bag is refused with the name of the tool that repairs it.

    Exit code 0: everything was imported; 1: a part; 2: nothing.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import tool_path
    from end_effector_lab.bags import Bag, import_bag

    tool = None
    if description or profile:
        tool = load_tool(tool_path(description or "", profile, how="--description FILE or --profile NAME"))
    if output is None:
        output = Path("runs", bag.resolve().stem)
    with Progress(f"Importing {bag}", shown=not as_json), closing(Bag(bag)) as opened:
        imported = import_bag(opened, output, description=tool, namespace=namespace)
    if as_json:
        print_document(imported.as_json())
    else:
        click.echo(
            f"{imported.folder}: {imported.tool}, {imported.seconds:.3f} s, {imported.states} states, "
            f"{imported.pressures} pressures"
        )
        for note in imported.notes:
            click.echo(f"Note: {note}", err=True)
        for fault in imported.faults:
            click.echo(f"Not imported: {fault}", err=True)
    if imported.faults:
        raise click.exceptions.Exit(1)
