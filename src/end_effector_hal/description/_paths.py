"""Paths on the machine: the shipped profiles and the run directory."""

from __future__ import annotations

import os
from pathlib import Path

from end_effector_hal.errors import UsageError, WireError
from end_effector_hal.owned import owned_folder


def own_directory(path: Path) -> Path:
    """Return the directory, for this user alone (mode 0700); create it if it is missing.

    A directory or a link that another user created there first is refused.

    Raises:
        WireError: it is not a directory, belongs to another user, or can be written by others.
    """
    try:
        owned_folder(path, 0o700).chmod(0o700)
    except OSError as error:
        raise WireError(
            f"the run directory is not for this user alone: {error.strerror}.",
            where=str(path),
            todo="Set EEHAL_RUN_DIR to a directory that only the programs of the tool can write, or remove that one.",
        ) from error
    return path


SHARED = Path("/tmp")
PROFILES = Path(__file__).resolve().parent.parent / "profiles"
SHIPPED_AUTOMATA = PROFILES / "end_effector.xml"
"""The UPPAAL file of every tool that has none of its own."""


def profile_path(name: str = "verdin_gripper") -> Path:
    """Return the YAML file of a shipped profile.

    Raises:
        UsageError: no profile has that name.
    """
    path = PROFILES / name / "end_effector.yaml"
    shipped = profile_names()
    if name not in shipped:
        raise UsageError(f"no profile is named {name!r}.", todo=f"Shipped: {', '.join(shipped)}.")
    return path


def profile_names() -> list[str]:
    """Return the names of the shipped profiles in alphabetical order."""
    return sorted(each.parent.name for each in PROFILES.glob("*/end_effector.yaml"))


def tool_path(description: str | Path, profile: str, *, how: str) -> Path:
    """Return the absolute path of the YAML file of the tool to be driven; there is no default tool.

    Args:
        description: path of a file; empty: not given. A relative path starts at the working directory.
        profile: name of a shipped profile; empty: not given.
        how: how the user can give one of them, such as ``FILE or --profile NAME``.

    Raises:
        UsageError: neither or both are given, or no profile has that name.
    """
    if bool(str(description)) == bool(profile):
        what = "Two tools are named" if profile else "No tool is named"
        shipped = ", ".join(profile_names())
        raise UsageError(
            f"{what}: exactly one tool is needed.", todo=f"Give {how}; shipped profiles: {shipped}."
        )
    return profile_path(profile) if profile else Path(description).expanduser().absolute()


def run_directory() -> Path:
    """Return the directory for the sockets of running programs.

    It is ``$EEHAL_RUN_DIR``, else ``/run/eehal`` if it can be written, else ``$XDG_RUNTIME_DIR/eehal``, else
    ``/tmp/eehal-<uid>`` for this user alone. Only the last one is created here.

    Raises:
        WireError: the last one exists already and is not for this user alone.
    """
    if chosen := os.environ.get("EEHAL_RUN_DIR"):
        return Path(chosen)
    system = Path("/run/eehal")
    if os.access(system if system.exists() else system.parent, os.W_OK):
        return system
    if runtime := os.environ.get("XDG_RUNTIME_DIR"):
        return Path(runtime) / "eehal"
    return own_directory(SHARED / f"eehal-{os.getuid()}")
