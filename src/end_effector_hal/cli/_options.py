"""Helpers that commands share: paths, output files and folders, and signals that end a command."""

from __future__ import annotations

import os
import signal
import stat
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

import click

from end_effector_hal._extras import lab_installed
from end_effector_hal.errors import UsageError, os_errors

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
MOST_SEED = 2**32 - 1


class PathName(click.Path):
    """An option type that becomes a `Path`. It refuses an empty text, which an unset shell variable leaves, instead of
    using the current folder.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(path_type=Path, **options)

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> str | bytes | os.PathLike[str]:
        """Return the path; fail with a usage error if the text is empty or the path cannot be reached."""
        if value == "":
            self.fail("It is empty. Write '.' for the current folder.", param, ctx)
        try:
            if stat.S_ISDIR(os.stat(value).st_mode):
                os.stat(
                    os.path.join(value, ".")
                )  # what is in it cannot be reached without the right to search it
        except (FileNotFoundError, NotADirectoryError):  # each command says what it had expected
            pass
        except OSError as error:  # links in a circle, a name that is too long, a folder that is not ours
            self.fail(
                f"{click.format_filename(value)[:200]!r} cannot be reached: {error.strerror}.", param, ctx
            )
        return super().convert(value, param, ctx)


def seed_option(*, default: int | None, help: str) -> Callable[[Decorated], Decorated]:
    """``--seed N``: of what is drawn in a simulation."""
    type_ = click.IntRange(0, MOST_SEED)
    return click.option(
        "--seed", default=default, metavar="N", type=type_, hidden=not lab_installed(), help=help
    )


def drawing_option(help: str, *, default: str | None = None) -> Callable[[Decorated], Decorated]:
    """``-o``: a folder, or the file of one drawing."""
    return click.option(
        "-o", "--output", metavar="DIR|FILE.(png|svg)", type=PathName(), default=default,
        show_default=default is not None, help=help,
    )  # fmt: skip


def until_ended() -> threading.Event:
    """Return the event that SIGTERM, SIGHUP and Ctrl-C set from now on."""
    ended = threading.Event()
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    return ended


def end_in_order() -> None:
    """Make SIGTERM and SIGHUP raise SystemExit in the main thread, so that all work in progress is ended properly."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _end)


def _end(number: int, _frame: FrameType | None) -> None:
    sys.exit(128 + number)


def the_folder(path: Path) -> Path:
    """Return the folder after making it if it does not exist."""
    with os_errors("The folder cannot be made", path):
        path.mkdir(parents=True, exist_ok=True)
    return path


def refuse_inputs(output: Path, inputs: Iterable[Path]) -> None:
    """Raise UsageError if the output is one of the files that the command reads, also under another name."""
    for each in inputs:
        with suppress(OSError):  # one of them does not exist
            if output.samefile(each):
                what = f"The command reads this file ({each}), and would replace it."
                raise UsageError(what, where=str(output), todo="Name another file with -o.")


def write_or_print(output: Path | None, text: str | bytes, inputs: Iterable[Path]) -> None:
    """Write a text to a file, completely or not at all, and print its path; without a file print the text.

    Raises:
        UsageError: the file cannot be written, or is one of the ``inputs``.
    """
    if output is None:
        click.echo(text, nl=False)
        return
    refuse_inputs(output, inputs)
    write_whole(output, text if isinstance(text, bytes) else text.encode())
    click.echo(str(output))


def write_whole(path: Path, data: bytes) -> None:
    """Write a file completely or not at all; write directly into a device or pipe such as /dev/stdout."""
    beside: Path | None = None
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)  # never in its place: a device would be gone
            return
        path = path.resolve()  # a link stays one
        beside = path.with_name(f".{path.name}.{os.getpid()}")
        beside.write_bytes(data)
        beside.replace(path)
    except OSError as error:
        if beside is not None:
            beside.unlink(missing_ok=True)
        raise UsageError(f"The file cannot be written: {error.strerror}.", where=str(path)) from None
