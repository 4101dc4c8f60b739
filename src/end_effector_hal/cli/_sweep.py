"""``--sweep``: proves many descriptions with a function of the development tools, which is found by an entry point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol, cast

from end_effector_hal._extras import lab_installed, lab_needed
from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins

GROUP = "end_effector_hal.sweep"
NAME = "lab"


class Sweep(Protocol):
    """The function that the entry point names."""

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
        """Prove every combination and print the results; return the exit code."""
        ...


def _checked(function: Any) -> Sweep:
    if not callable(function):
        raise UsageError("it is not a function.")
    return cast(Sweep, function)


_SWEEPS: Plugins[Sweep] = Plugins(GROUP, "sweep", {}, _checked, make=False)


def sweep() -> Sweep:
    """Return the function that proves a grid of values.

    Raises:
        MissingExtraError: the function is not installed.
        UsageError: the function cannot be loaded.
    """
    if not lab_installed():
        raise lab_needed("--sweep")
    return _SWEEPS.get(NAME)
