"""``eehal page``: the live page of a tool, or recordings in it; and how every command opens a recording."""

from __future__ import annotations

import atexit
import os
import re
import shutil
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from stat import S_IROTH, S_ISREG
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any, TypeVar

import click

from end_effector_hal._extras import lab
from end_effector_hal.errors import UsageError, os_errors

from ._options import PathName

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.page.recorded import RecordedTables, RecordingFiles, RecordingPart


TRACE, BAGS = ".mcap", (".bag", ".active", ".db3")
TABLE, OF_BAG = "states.csv", "metadata.yaml"


Command = TypeVar("Command", bound=Callable[..., Any])


def recording_options(command: Command) -> Command:
    """Add the options ``--description``, ``--from`` and ``--to`` as the parameters ``description``, ``since``,
    ``until``.
    """
    seconds = click.FloatRange(min=0)
    for option in (
        click.option("--to", "until", metavar="SECONDS", type=seconds, help="Show a recording up to there."),
        click.option(
            "--from", "since", metavar="SECONDS", type=seconds, help="Show a recording from there on."
        ),
        click.option(
            "--description",
            metavar="FILE",
            type=PathName(),
            help="For a bag, which holds none; or to use another tool.",
        ),
    ):
        command = option(command)
    return command


def is_recording(path: Path) -> bool:
    """Return whether a path is a recording and not a description."""
    return path.is_dir() or path.suffix in (TRACE, *BAGS)


def runs_in(folder: Path) -> tuple[Path, ...]:
    """Return the recordings in a folder and its subfolders, sorted by name; () if the folder itself is a recording.
    Links to folders are not followed.
    """
    if not folder.is_dir() or _is_run(os.listdir(folder)):
        return ()
    return tuple(sorted(Path(each) for each, _, names in os.walk(folder) if _is_run(names)))


def _is_run(names: Sequence[str]) -> bool:
    return any(name in (TABLE, OF_BAG) or name.endswith(TRACE) for name in names)


def open_recordings(paths: Sequence[Path], description: Path | None) -> list[RecordingFiles | RecordedTables]:
    """Open the recordings for one page; raises UsageError for a path that is no recording, and for more than two."""
    if len(paths) > 2:
        raise UsageError(f"{len(paths)} recordings cannot be compared.", todo="Name one, or two.")
    return [_open(each, description) for each in paths]


def part_of(since_s: float | None, until_s: float | None) -> RecordingPart:
    """Return the part of a recording that is shown; raises UsageError if it would be empty."""
    from end_effector_hal.page.recorded import RecordingPart

    if not all(isfinite(each) for each in (since_s or 0.0, until_s or 0.0)):
        raise UsageError("--from and --to are seconds.")
    if since_s is not None and until_s is not None and until_s <= since_s:
        raise UsageError(f"--to {until_s:g} is not after --from {since_s:g}.")
    return RecordingPart(since_s, until_s)


def _open(path: Path, description: Path | None) -> RecordingFiles | RecordedTables:
    from end_effector_hal.page.recorded import RecordedTables, RecordingFiles

    if path.suffix in BAGS or (path / OF_BAG).exists():
        return _bag(path, description)
    try:
        return RecordingFiles(path, None if description is None else _tool(path, description))
    except UsageError as error:
        if (path / TABLE).exists() and not list(path.glob(f"*{TRACE}")):
            return RecordedTables(path, _tool(path, description))
        if path.suffix == TRACE and path.is_file() and description is not None:
            return _bag(path, description)
        if runs := runs_in(path):
            what = f"This folder is not a recording: it contains {len(runs)} of them."
            todo = f"Name one of them ({runs[0]}), or write all into one file: `eehal report {path}`."
            raise UsageError(what, where=str(path), todo=todo) from None
        if path.suffix == TRACE:
            todo = f"{error.todo} A ROS bag is shown with --description FILE.".strip()
            raise UsageError(error.what, where=error.where, todo=todo) from None
        raise


def _tool(path: Path, description: Path | None) -> Description:
    from end_effector_hal.codecs import load_tool

    if description is None:
        raise UsageError(
            "This recording does not contain its description.",
            where=str(path),
            todo="Name it: --description FILE.",
        )
    return load_tool(description)


def _bag(path: Path, description: Path | None) -> RecordedTables:
    from end_effector_hal.page.recorded import RecordedTables

    tool = _tool(path, description)
    made = Path(mkdtemp(prefix="eehal-bag-"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    found = lab("bags").record_bag(path, made / "recording", tool)
    return RecordedTables(made / "recording", tool, path.resolve().name, (*found.notes, *found.faults))


PORT = 8137
LEAST_SECRET, MOST_SECRET = 16, 200
"""Length of the secret by which a monitoring system reads the metrics, characters."""


def _secret(path: Path) -> str:
    """Return the secret in a file, which others should not read; raises UsageError if it is no word of a sufficient
    length.
    """
    with os_errors("The secret cannot be read", path):
        found = path.stat()
        if not S_ISREG(found.st_mode):  # reading a pipe or a device may never end
            raise UsageError("This is no regular file.", where=str(path), todo="Name a file with the secret.")
        with path.open("rb") as file:
            text = file.read(MOST_SECRET + 2).decode("ascii", errors="replace").strip()
    if found.st_mode & S_IROTH:
        click.echo(f"Note: every user of this machine can read the secret: chmod o-r {path}.", err=True)
    if not (LEAST_SECRET <= len(text) <= MOST_SECRET and re.fullmatch(r"[\x21-\x7e]+", text)):
        what = f"This file must hold one word of {LEAST_SECRET} to {MOST_SECRET} ASCII characters."
        raise UsageError(what, where=str(path), todo="Make one: openssl rand -hex 24.")
    return text


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
@click.option(
    "--metrics-token",
    metavar="FILE",
    type=PathName(),
    help="File with a secret by which Prometheus reads /metrics of a live tool.",
)
@recording_options
def command(
    what: tuple[Path, ...],
    host: str,
    port: int,
    names: tuple[str, ...],
    recordings: Path | None,
    metrics_token: Path | None,
    description: Path | None,
    since: float | None,
    until: float | None,
) -> None:
    """Show a tool in a browser: live, or as it was recorded.

    DESCRIPTION: shows states, pressures, interlocks, and why a command is refused. The page follows the HAL that runs
    with the same description (`eehal run`, `eehal serve`, the nodes of ROS 1 or 2) by its local socket, and reconnects
    when it restarts. The printed address contains a token; a browser that has the token sees the tool and may take
    control. Closing the page, or ending this command, moves no line. The page also lists and opens the recordings of a
    folder.

    RECORDING: a folder of `eehal run --record`, one of its traces, or a ROS bag, in the same page: scrub, step from
    transition to transition, and compare with a second one. Nothing can be commanded there.
    """
    from end_effector_hal.page.web import PageAddress, serve_page, serve_recordings

    scraper = "" if metrics_token is None else _secret(metrics_token)
    address = PageAddress(host, port, names, scraper=scraper)

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
    if recordings is not None or metrics_token is not None:
        raise UsageError("--recordings and --metrics-token are for a live tool.", where=str(what[0]))
    serve_recordings(open_recordings(what, description), part_of(since, until), address, ready)
