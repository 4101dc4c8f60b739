"""The command ``eehal listen``: a live table on a terminal, elsewhere a line for each change."""

from __future__ import annotations

import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli._json_output import print_line
from end_effector_hal.cli._options import PathName, end_in_order
from end_effector_hal.errors import LinkBusyError

from ._channel_changes import ChannelChanges, print_words
from ._channel_view import ChannelView

if TYPE_CHECKING:
    from end_effector_hal.description import Description

TICK_S = 0.1


@click.command("listen")
@click.argument("description", type=PathName())
@click.option(
    "--seconds",
    type=click.FloatRange(min=0, min_open=True),
    help="Stop after this time; default: run until Ctrl-C.",
)
@click.option(
    "--suggest",
    metavar="FOLDER",
    type=PathName(),
    help="Instead: propose thresholds from a recorded grip and drop.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(description: Path, seconds: float | None, suggest: Path | None, as_json: bool) -> None:
    """Show what arrives on each channel of DESCRIPTION: raw value, scaled value, evidence, age, rate, errors.

    The command only reads links and inputs of the board: no output moves. Values that the line arbiter reads itself (a
    bus that is commanded, inputs that interlocks need) come from the arbiter, if it runs. On a terminal a table is
    refreshed, elsewhere a line is printed for each change. A port that another process reads is not opened.

    --suggest reads a recording (`eehal run --record FOLDER`) of a grip and a drop, and proposes thresholds with the
    recorded levels that justify them.
    """
    from end_effector_hal.codecs import load_tool

    tool = load_tool(description)
    if suggest is not None:
        from ._suggest import print_suggestions

        print_suggestions(tool, suggest, as_json=as_json)
        return
    end_in_order()
    for link in tool.links.values():
        _refuse_busy(link.port)
    with suppress(KeyboardInterrupt):  # how a live view is left
        _listen(tool, seconds, as_json=as_json)


def _refuse_busy(port: str) -> None:
    from end_effector_hal.wires import holders_of

    if holders := holders_of(port):
        raise LinkBusyError(
            f"the port is read by {' and '.join(map(str, holders))}.",
            where=port,
            todo="Stop that program: two readers would steal each other's bytes.",
        )


def _listen(tool: Description, seconds: float | None, *, as_json: bool) -> None:
    from end_effector_hal.wires import now_us

    if not as_json and sys.stdout.isatty():
        import rich.live  # noqa: F401 now: frames would wait for it
    heard = ChannelView(tool, now_us())
    end = None if seconds is None else heard.begun + round(seconds * 1e6)
    with heard:
        _show(heard, end, as_json=as_json)
    heard.need_frames()


def _show(heard: ChannelView, end: int | None, *, as_json: bool) -> None:
    from end_effector_hal.wires import now_us

    def hear() -> bool:
        now = now_us()
        if end is not None and now >= end:
            return False
        heard.hear(TICK_S if end is None else min(TICK_S, (end - now) / 1e6))
        return True

    if as_json or not sys.stdout.isatty():
        changes = ChannelChanges(heard, _print_json if as_json else partial(print_words, heard.measure))
        while hear():
            changes.tell(now_us())
        return
    from rich.live import Live

    with Live(heard.table(now_us()), refresh_per_second=8) as live:
        while hear():
            live.update(heard.table(now_us()))


def _print_json(content: dict[str, object]) -> None:
    print_line(**content)
