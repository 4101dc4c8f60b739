"""Where things stand on the machine: shipped profiles, the run directory."""

from __future__ import annotations

import os
from pathlib import Path

from end_effector_hal.errors import UsageError, WireError
from end_effector_hal.owned import owned_folder


def own_directory(path: Path) -> Path:
    """The directory, made if it is missing, for this user alone (mode 0700).

    Somebody else may have been there first, with a directory or a link of that name: then it is refused.

    Raises:
        WireError: it is not a directory, or belongs to another user, or others may write there.
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


def profile_path(name: str = "verdin_gripper") -> Path:
    """The YAML file of a shipped profile.

    Raises:
        UsageError: no profile has that name.
    """
    path = PROFILES / name / "end_effector.yaml"
    shipped = profile_names()
    if name not in shipped:
        raise UsageError(f"no profile is named {name!r}.", todo=f"Shipped: {', '.join(shipped)}.")
    return path


def profile_names() -> list[str]:
    """The shipped profiles, in the order of the alphabet."""
    return sorted(each.parent.name for each in PROFILES.glob("*/end_effector.yaml"))


def tool_path(description: str | Path, profile: str, *, how: str) -> Path:
    """The YAML file of the tool that a program is to drive, absolute: no tool is ever taken by default.

    Args:
        description: path of a file; empty: none is given. A relative one starts at the working directory.
        profile: name of a shipped one; empty: none is given.
        how: the way to give one of them, such as ``FILE or --profile NAME``.

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
    """Where sockets of running programs stand; only the last resort is created here.

    ``$EEHAL_RUN_DIR``, else ``/run/eehal`` if it can be written, else ``$XDG_RUNTIME_DIR/eehal``, else
    ``/tmp/eehal-<uid>``, which is for this user alone.

    Raises:
        WireError: somebody else was first at the last resort.
    """
    if chosen := os.environ.get("EEHAL_RUN_DIR"):
        return Path(chosen)
    system = Path("/run/eehal")
    if os.access(system if system.exists() else system.parent, os.W_OK):
        return system
    if runtime := os.environ.get("XDG_RUNTIME_DIR"):
        return Path(runtime) / "eehal"
    return own_directory(SHARED / f"eehal-{os.getuid()}")
