"""Extras of the distribution: packages that only some commands and codecs need."""

from __future__ import annotations

import re

from end_effector_hal.errors import MissingExtraError

DISTRIBUTION = "end-effector-hal"
_ADDED = re.compile(r"""(?P<package>[\w.-]+).*;.*\bextra == ['"](?P<extra>[\w-]+)['"]""")


def extras() -> dict[str, tuple[str, ...]]:
    """The packages that each extra adds; nothing where the package was copied without its metadata."""
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


def missing_extra(what_needs: str, error: ModuleNotFoundError) -> MissingExtraError | None:
    """The sentence for a module that was not found, with the command; None: no extra adds it.

    Args:
        what_needs: how the sentence begins, such as ``Figures need``.
        error: of the import.
    """
    module = (error.name or "").partition(".")[0]
    for extra, packages in extras().items():
        if module in packages:
            what = f"{what_needs} {module}, which is not installed."
            return MissingExtraError(what, todo=f"Install it: {command_for(extra)}.")
    return None


def command_for(extra: str) -> str:
    """The command that installs an extra, and where."""
    return f"pip install '.[{extra}]' in a checkout of {DISTRIBUTION}"
