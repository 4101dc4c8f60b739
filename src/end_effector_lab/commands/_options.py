"""Options of commands that play thousands of runs: the folder of the results, and the workers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar

import click

from end_effector_hal.cli import PathName, Progress

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


class TimeLeft:
    """Estimates the time until all items are done from the rate since the first call."""

    def __init__(self) -> None:
        self._begun, self._first = time.monotonic(), -1

    @property
    def passed_s(self) -> float:
        """The time since the beginning, s."""
        return time.monotonic() - self._begun

    def __call__(self, done: int, of: int) -> float:
        """Return the time left, s; 0: it is not known yet."""
        self._first = done if self._first < 0 else self._first
        return (of - done) * self.passed_s / (done - self._first) if done > self._first else 0.0


def counted(progress: Progress, noun: str) -> Callable[[int, int], None]:
    """Return a function that shows how many items are done, of how many, and the time left."""
    left = TimeLeft()
    return lambda done, of: progress(f"{done} of {of} {noun}, {left(done, of) / 60:.0f} min left")


def playing_options(noun: str, gets: str) -> Callable[[Decorated], Decorated]:
    """Return the options ``-o FOLDER``, ``--jobs N``, ``--scheduler ADDRESS`` and ``--json``.

    Args:
        noun: name of the command and of its folder.
        gets: the folder's content, in words.
    """
    options = (
        click.option(
            "-o",
            "--output",
            metavar="FOLDER",
            default=f"runs/{noun}",
            show_default=True,
            type=PathName(),
            help=f"A new folder that gets {gets}.",
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
