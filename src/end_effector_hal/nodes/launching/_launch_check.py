"""The check of a launch file before it starts anything: which tool is meant, and whether the nodes can work with it.

The launch file runs it while it is read; if it fails, nothing is started.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from end_effector_hal.description import Description, tool_path
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.interface import load_for_nodes
from end_effector_hal.nodes.process import guarded
from end_effector_hal.runtime import load_automata

NAME = "end_effector.launch"


def check_launch(argv: Sequence[str], launcher: str) -> int:
    """Print the name, the fingerprint and the path of the tool, or one sentence why it cannot be launched.

    Args:
        argv: ``--description`` as it was given, ``--file``: the path that the nodes will read, ``--profile``.
        launcher: the program that reads the launch file.

    Returns:
        The exit code.
    """
    return guarded(NAME, lambda: _check(argv, launcher))


def _check(argv: Sequence[str], launcher: str) -> None:
    parser = argparse.ArgumentParser(prog=NAME)
    for option in ("--description", "--file", "--profile"):
        parser.add_argument(option, default="")
    given = parser.parse_args(argv)
    how = f"description:=FILE or profile:=NAME ({launcher} ignores an argument that it does not know)"
    path = tool_path(given.file, given.profile, how=how)
    _is_the_one_meant(given.description, path)
    description = load_for_nodes(path)
    load_automata(description)
    print(_identity(description, path))  # noqa: T201 the launch file reads it


def _is_the_one_meant(given: str, path: Path) -> None:
    """Raise UsageError if ``$PWD`` and the current folder lead from a relative path to different files."""
    meant = Path(given).expanduser()
    if given and not meant.is_absolute() and os.path.realpath(meant) != os.path.realpath(path):
        raise UsageError(
            f"The relative path {given} means {meant.absolute()} here, but $PWD leads to {path}.",
            todo="Give an absolute path.",
        )


def _identity(description: Description, path: Path) -> str:
    return f"{description.name} {description.fingerprint()} {path}"
