"""The check of the launch file before it starts anything: which tool it is, and whether the nodes can work with it.

roslaunch runs it as the command of a parameter while it reads the file; when it fails, nothing is started.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from end_effector_hal.description import Description, tool_path
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.interface import load_for_nodes
from end_effector_hal.runtime import load_automata

HOW = "description:=FILE or profile:=NAME (roslaunch ignores an argument that it does not know)"


def launch_check(argv: Sequence[str]) -> None:
    """Print the name, the fingerprint and the path of the tool.

    Args:
        argv: ``--description`` as it was given, ``--file``: the path that the nodes will read, ``--profile``.

    Raises:
        UsageError: no tool is named, or its nodes would read another file than the one that was meant.
        ReportedError: the description, its codec or its automata are not valid.
    """
    parser = argparse.ArgumentParser(prog="end_effector.launch")
    for option in ("--description", "--file", "--profile"):
        parser.add_argument(option, default="")
    given = parser.parse_args(argv)
    path = tool_path(given.file, given.profile, how=HOW)
    _is_the_one_meant(given.description, path)
    description = load_for_nodes(path)
    load_automata(description)
    print(_identity(description, path))  # noqa: T201 it becomes the value of the parameter


def _is_the_one_meant(given: str, path: Path) -> None:
    """A relative path was completed from ``$PWD``, which may be another folder than the one that we are in."""
    meant = Path(given).expanduser()
    if given and not meant.is_absolute() and os.path.realpath(meant) != os.path.realpath(path):
        raise UsageError(
            f"The relative path {given} means {meant.absolute()} here, but $PWD leads to {path}.",
            todo="Give an absolute path.",
        )


def _identity(description: Description, path: Path) -> str:
    return f"{description.name} {description.fingerprint()} {path}"
