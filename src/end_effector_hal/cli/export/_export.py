"""``eehal export``: writes files about the tool for other programs."""

from __future__ import annotations

import click

from ._foxglove import export_foxglove
from ._sros2 import export_sros2
from ._urdf import export_urdf


@click.group(name="export")
def command() -> None:
    """Write files about a tool for other programs."""


command.add_command(export_foxglove)
command.add_command(export_sros2)
command.add_command(export_urdf)
