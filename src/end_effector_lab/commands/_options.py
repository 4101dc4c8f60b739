"""Options of commands that play thousands of runs: the folder of the results, and the workers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from end_effector_hal.cli import PathName

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


def playing_options(noun: str, gets: str) -> Callable[[Decorated], Decorated]:
    """Return the options ``-o FOLDER``, ``--jobs N``, ``--scheduler ADDRESS`` and ``--json``.

    Args:
        noun: name of the command and of its folder.
        gets: the help text on the folder's content, as a sentence without its full stop.
    """
    options = (
        click.option(
            "-o",
            "--output",
            metavar="FOLDER",
            default=f"runs/{noun}",
            show_default=True,
            type=PathName(),
            help=f"{gets}; a {noun} that was stopped there goes on.",
        ),
        click.option("--jobs", type=click.IntRange(1), help="Processes; default: one for each processor."),
        click.option(
            "--scheduler",
            metavar="ADDRESS",
            help="Play on the workers of this scheduler of dask.distributed, such as tcp://10.0.0.1:8786.",
        ),
        click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON, in one line."),
    )

    def decorated(function: Decorated) -> Decorated:
        for option in reversed(options):
            function = option(function)
        return function

    return decorated
