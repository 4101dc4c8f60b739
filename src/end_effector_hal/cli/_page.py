"""``eehal page``: the live page of a tool."""

from __future__ import annotations

from pathlib import Path

import click

from ._options import PathName

PORT = 8137


@click.command("page")
@click.argument("description", type=PathName())
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", default=PORT, show_default=True, type=click.IntRange(0, 65535), help="0: one that is free."
)
@click.option(
    "--name", "names", multiple=True, metavar="NAME", help="A name by which browsers reach it, beside --host."
)
def command(description: Path, host: str, port: int, names: tuple[str, ...]) -> None:
    """Show the tool of DESCRIPTION live in a browser: states, pressures, interlocks, why a command is refused.

    It follows the programs that run with the same description (`eehal run`, the nodes of ROS 1 or 2) by their local
    sockets, and finds them again. The printed address has a token: whoever opens it sees the tool, and may take
    control. Closing the page, or ending this command, moves no line.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.page import PageAddress, serve_page

    tool = load_tool(description)
    address = PageAddress(host, port, names)

    def ready(url: str) -> None:
        click.echo(url)
        if not address.loopback:
            click.echo("Note: other machines reach this page, without encryption.", err=True)

    serve_page(tool, address, ready)
