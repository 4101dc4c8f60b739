"""``eehal page``: serves the live page of a tool, or shows recordings in the same page."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli._options import PathName
from end_effector_hal.errors import UsageError

from ._recordings import is_recording, open_recordings, part_of, recording_options

PORT = 8137


@click.command("page")
@click.argument("what", metavar="DESCRIPTION|RECORDING [RECORDING]", nargs=-1, required=True, type=PathName())
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", default=PORT, show_default=True, type=click.IntRange(0, 65535), help="0: one that is free."
)
@click.option(
    "--name", "names", multiple=True, metavar="NAME", help="A name by which browsers reach it, beside --host."
)
@click.option(
    "--recordings",
    metavar="DIR",
    type=PathName(),
    help="Of a live tool: the folder whose recordings the page lists.  [default: runs]",
)
@recording_options
def command(
    what: tuple[Path, ...],
    host: str,
    port: int,
    names: tuple[str, ...],
    recordings: Path | None,
    description: Path | None,
    since: float | None,
    until: float | None,
) -> None:
    """Show a tool in a browser: live, or as it was recorded.

    DESCRIPTION: shows states, pressures, interlocks, and why a command is refused. The page follows the HAL that runs
    with the same description (`eehal run`, the nodes of ROS 1 or 2) by its local socket, and reconnects when it
    restarts. The printed address contains a token; a browser that has the token sees the tool and may take control.
    Closing the page, or ending this command, moves no line. The page also lists and opens the recordings of a folder.

    RECORDING: a folder of `eehal run --record`, one of its traces, or a ROS bag, in the same page: scrub, step from
    transition to transition, and compare with a second one. Nothing can be commanded there.
    """
    from end_effector_hal.page.web import PageAddress, serve_page, serve_recordings

    address = PageAddress(host, port, names)

    def ready(url: str) -> None:
        click.echo(url)
        if not address.loopback:
            click.echo("Note: other machines reach this page, without encryption.", err=True)

    if not any(is_recording(each) for each in what):
        if len(what) > 1:
            raise UsageError("One description is shown at a time.", todo="Two recordings can be compared.")
        if (since, until, description) != (None,) * 3:
            raise UsageError("--from, --to and --description are for recordings.", where=str(what[0]))
        from end_effector_hal.codecs import load_tool

        serve_page(load_tool(what[0]), address, recordings or Path("runs"), ready)
        return
    if recordings is not None:
        raise UsageError("--recordings is for a live tool.", where=str(what[0]))
    serve_recordings(open_recordings(what, description), part_of(since, until), address, ready)
