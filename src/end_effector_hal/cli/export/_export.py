"""``eehal export``: the tool for other programs."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli._options import PathName, write_whole
from end_effector_hal.description import profile_path
from end_effector_hal.nodes.interface import load_for_nodes

from ._urdf import urdf


@click.group(name="export")
def command() -> None:
    """Write what other programs need to know of a tool."""


@command.command(name="urdf", short_help="A xacro with its links, joints and ros2_control entries.")
@click.argument("file", type=PathName(), required=False)
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_urdf(file: Path | None, output: Path | None) -> None:
    """Write a xacro of the tool that the description FILE says; default: the shipped one.

    Its names are those of joint_states. A description has no dimensions but strokes: places, axes, shapes and masses
    stand as EDIT, and until they are edited a planner does not see the tool.
    """
    text = urdf(load_for_nodes(file or profile_path()))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_whole(output, text.encode())
        click.echo(str(output))
