"""The tool that a program of the ROS package is started for: its launcher names it, there is no default."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from end_effector_hal.description import tool_path
from end_effector_hal.nodes.interface import DESCRIPTION, PROFILE, Parameter

HOW = "_description:=FILE or _profile:=NAME"


def tool_named(argv: Sequence[str], parameter: Callable[[Parameter], str]) -> Path:
    """The description that the arguments name, else the private parameters.

    What an earlier start left on the parameter server does not count besides arguments.

    Args:
        argv: of the program; ``_description:=`` and ``_profile:=`` name a tool, empty ones none.
        parameter: gives a private parameter, empty if it is not set.

    Raises:
        UsageError: neither or both are given, or no profile has that name.
    """
    given = [_argument(argv, each) for each in (DESCRIPTION, PROFILE)]
    if given == [None, None]:
        given = [parameter(DESCRIPTION), parameter(PROFILE)]
    return tool_path(given[0] or "", given[1] or "", how=HOW)


def _argument(argv: Sequence[str], parameter: Parameter) -> str | None:
    key = f"_{parameter.name}:="
    return next((each.removeprefix(key).strip() for each in argv if each.startswith(key)), None)
