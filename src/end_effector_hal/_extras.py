"""Extras of the distribution: optional packages that only some commands and codecs need."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from end_effector_hal.errors import MissingExtraError

DISTRIBUTION = "end-effector-hal"
_LAB = ("mcap",)
"""What the commands of the lab need; without it they are hidden. Figures also need matplotlib, and say so."""
_ADDED = re.compile(r"""(?P<package>[\w.-]+).*;.*\bextra == ['"](?P<extra>[\w-]+)['"]""")


def extras() -> dict[str, tuple[str, ...]]:
    """Return the packages that each extra adds; empty if the package was copied without its metadata."""
    from importlib.metadata import PackageNotFoundError, requires

    found: dict[str, tuple[str, ...]] = {}
    try:
        needed = requires(DISTRIBUTION) or ()
    except PackageNotFoundError:
        return found
    for requirement in needed:
        if match := _ADDED.match(requirement):
            found[match["extra"]] = (*found.get(match["extra"], ()), match["package"])
    return found


def version_of(package: str) -> str:
    """Return the version of an installed package; empty if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    with suppress(PackageNotFoundError):
        return version(package)
    return ""


@cache
def lab_installed() -> bool:
    """Return whether the commands of `end_effector_lab` can be used; a robot does not need them."""
    with suppress(ModuleNotFoundError):
        return all(map(find_spec, _LAB))
    return False


def lab(module: str) -> Any:
    """Return a module of `end_effector_lab`, which uses this package; what it needs may not be installed."""
    return import_module(f"end_effector_lab.{module}")


def lab_needed(what: str) -> MissingExtraError:
    """Return the error for a command or option that needs the extra `lab`, which is not installed."""
    return MissingExtraError(
        f"{what} needs the extra lab, which is not installed.", todo=f"Install it: {command_for('lab')}."
    )


def missing_extra(what_needs: str, error: ModuleNotFoundError) -> MissingExtraError | None:
    """Return an error with the missing module and the command to install it; None: no extra contains the module.

    Args:
        what_needs: the beginning of the sentence, such as ``Figures need``.
        error: the error that the import raised.
    """
    module = (error.name or "").partition(".")[0]
    for extra, packages in sorted(extras().items(), key=lambda each: len(each[1])):  # the smallest will do
        if module.replace("_", "-") in packages:
            what = f"{what_needs} {module}, which is not installed."
            return MissingExtraError(what, todo=f"Install it: {command_for(extra)}.")
    return None


def command_for(extra: str) -> str:
    """Return the command that installs an extra, and the folder in which to run it."""
    return f"pip install '.[{extra}]' in a checkout of {DISTRIBUTION}"
