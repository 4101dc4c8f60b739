"""``--sweep``: proofs of many descriptions come from the development tools, found by an entry point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol, cast

from end_effector_hal._extras import command_for
from end_effector_hal.errors import MissingExtraError, UsageError
from end_effector_hal.plugins import Plugins

GROUP = "end_effector_hal.sweep"
NAME = "lab"


class Sweep(Protocol):
    """What the entry point names."""

    def __call__(
        self,
        path: Path,
        wanted: Sequence[str],
        *,
        scheduler: str | None,
        jobs: int | None,
        output: Path | None,
        as_json: bool,
    ) -> int:
        """Prove each combination and print it; the exit code."""
        ...


def _checked(function: Any) -> Sweep:
    if not callable(function):
        raise UsageError("it is not a function.")
    return cast(Sweep, function)


_SWEEPS: Plugins[Sweep] = Plugins(GROUP, "sweep", {}, _checked, make=False)


def sweep() -> Sweep:
    """The function that proves a grid.

    Raises:
        MissingExtraError: it is not installed.
        UsageError: it cannot be loaded.
    """
    if NAME not in _SWEEPS.names:
        raise MissingExtraError(
            "The package that proves a grid of values is not installed.",
            todo=f"Install it: {command_for('lab')}.",
        )
    return _SWEEPS.get(NAME)
