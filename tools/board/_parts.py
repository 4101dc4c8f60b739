"""The parts of an emulated board: built once for all checkouts, kept while new or in use."""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from end_effector_hal.owned import open_owned, owned_folder

from ._errors import BoardError

WHOLE = "root.cpio"
"""The file that is written last: a board with it is complete."""

_used: dict[Path, int] = {}


def keep(place: Path) -> bool:
    """Return whether a complete board exists there; if so, protect it from removal until this process ends."""
    try:
        used = os.open(place, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return False
    fcntl.flock(used, fcntl.LOCK_SH)
    if not (place / WHOLE).exists():  # removed while we waited, or not whole
        os.close(used)
        return False
    before = _used.pop(place, None)
    if before is not None:
        os.close(before)
    _used[place] = used
    return True


def forget_others(place: Path) -> list[str]:
    """Remove unused boards beside this one, and remains of aborted builds; return the names.

    Call it only while no other process builds.
    """
    others = sorted(each for each in place.parent.iterdir() if each.is_dir() and each != place)
    return [each.name for each in others if _forget(each)]


def _forget(old: Path) -> bool:
    try:
        folder = os.open(old, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:  # of somebody else
        return False
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        (old / WHOLE).unlink(missing_ok=True)  # first: half of it must not look whole
        shutil.rmtree(old)
    except OSError:  # in use
        return False
    finally:
        os.close(folder)
    return True


HERE = Path(__file__).parent
DISTRIBUTION = "end-effector-hal"
EXTRAS = ("extra == 'modbus'", "extra == 'recordings'")
"""On the board, too; figures are drawn here."""


def cache() -> Path:
    """Return the folder of built parts, which may be deleted at any time."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / DISTRIBUTION / "board"


def board_parts(say: Callable[[str], None] = lambda text: None) -> Path:
    """Return the folder with ``qemu/``, ``kernel``, ``board.dtb`` and ``root.cpio``; build it if it is missing.

    Its name is a hash of its ingredients, so that checkouts share it; a second process waits for the first. It is not
    removed until this process ends; after a new build, older boards are removed unless they are in use.

    Raises:
        BoardError: something needed is missing, with its Debian package, or the build failed.
    """
    requirements = "".join(f"{each}\n" for each in sorted(_requirements(DISTRIBUTION)))
    made_of = [
        *(HERE.joinpath(name).read_text() for name in ("build.sh", "_cpio.py", "packages.txt")),
        requirements,
    ]
    place = cache() / hashlib.sha256("\n".join(made_of).encode()).hexdigest()[:12]
    if keep(place):
        return place
    try:
        owned_folder(place.parent)
        with _alone(place.parent / "lock"):
            if not keep(place):
                say(f"building the emulated board once: some 250 MB of Debian packages, into {place}")
                begun = time.monotonic()
                _build(place, requirements)
                say(f"built in {time.monotonic() - begun:.0f} s")
                keep(place)
                for old in forget_others(place):
                    say(f"removed {old}, an older one")
    except OSError as error:
        if isinstance(error, BoardError):
            raise
        raise BoardError(
            f"The board cannot be built: {error.strerror}.",
            where=str(place.parent),
            todo="Set XDG_CACHE_HOME to a folder with 1.5 GB of room.",
        ) from error
    return place


def _build(place: Path, requirements: str) -> None:
    """Build beside the final place and move the complete result there."""
    new = place.with_name(f"{place.name}.new")
    for old in (new, place):
        shutil.rmtree(old, ignore_errors=True)
    new.mkdir()
    (new / "requirements.txt").write_text(requirements)
    command = ["bash", str(HERE / "build.sh"), str(new), str(new / "requirements.txt")]
    built = subprocess.run(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if built.returncode:
        lines = built.stderr.strip().splitlines() or [f"exit code {built.returncode}"]
        missing = built.returncode == 3
        raise BoardError(
            f"The emulated board cannot be built: {lines[-1]}",
            todo="" if missing else f"All of it: {new / 'build.log'}",
        )
    new.rename(place)


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    with os.fdopen(open_owned(path, os.O_WRONLY | os.O_CREAT, 0o644), "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _requirements(name: str, known: set[str] | None = None) -> set[str]:
    """Return ``name==version`` of all installed dependencies, without those for drawing."""
    known = set() if known is None else known
    found: set[str] = set()
    for text in distribution(name).requires or ():
        needed = re.split(r"[^A-Za-z0-9._-]", text, maxsplit=1)[0]
        key = re.sub(r"[-_.]+", "-", needed).lower()
        if ("extra ==" in text and not text.endswith(EXTRAS)) or key in known:
            continue
        known.add(key)
        try:
            version = distribution(needed).version
        except PackageNotFoundError:  # for another system or an older Python
            continue
        found |= {f"{key}=={version}"} | _requirements(needed, known)
    return found
