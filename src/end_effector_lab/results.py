"""A folder of results, in which a stopped computation can be continued.

Rule 1: Only one process writes to the folder at a time.
Rule 2: A file in the folder, the mark, identifies the computation. A folder with another mark is refused. A folder
    without a mark is refused if it contains a file with one of the names: files of other programs are never used as
    results.
Rule 3: Each result is a line of JSON. A truncated last line is removed; any other invalid line is an error that
    names its number.
Rule 4: The other files are written completely or not at all. An old file that a user has edited is kept beside the
    new one.
Rule 5: Links are not followed.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Self, TypeVar

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.cli import the_folder, write_whole
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import append_whole, lock, product_version
from end_effector_hal.vocabulary import printable

T = TypeVar("T")
K = TypeVar("K")

PACKAGES = ("timed_automata", "end_effector_hal", "end_effector_lab")
MOST_LINE, MOST_MARK = 4_000_000, 100_000
"""Maximum size of a line, and of the mark, bytes."""
WRITTEN = "written"
ELSEWHERE = "Name another folder with -o."
_WORDS = {
    "automata": "UPPAAL file",
    "keys": "set of keys",
    "version": "version of the program",
    "source": "state of the program's source",
}


def mark_of(description: Description, **more: object) -> dict[str, object]:
    """Return the mark: the tool, its UPPAAL file, the program, and additions of the computation, such as a seed.

    Plug-ins of other distributions are not included: after a change of a plug-in, use another folder.
    """
    path = description.automata_path
    with os_errors("The UPPAAL file cannot be read", path):
        automata = sha256(path.read_bytes()).hexdigest()[:12]
    return {
        "tool": description.name,
        "description": description.fingerprint(),
        "automata": automata,
        "version": product_version(),
        "source": source_checksum(),
    } | more


@cache
def source_checksum() -> str:
    """Return 12 hex digits of the hash of all files of the packages.

    In a checkout the source changes while the version stays the same.
    """
    found = sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for folder in (spec and spec.submodule_search_locations) or ():
            for file in sorted(Path(folder).rglob("*")):
                if file.suffix != ".pyc" and file.is_file():
                    found.update(f"{package}/{file.relative_to(folder)}\0".encode())
                    found.update(sha256(file.read_bytes()).digest())
    return found.hexdigest()[:12]


@dataclass(frozen=True)
class ResultsLayout:
    """Names in a folder of results.

    Attributes:
        noun: name of the computation, such as ``matrix``.
        mark, lines: names of the file that identifies the computation, and of the file with the results.
        todo: instruction to the user about a line that does not fit.
        files, folders: names of the other files and folders that the computation writes.
    """

    noun: str
    mark: str
    lines: str
    todo: str
    files: tuple[str, ...] = ()
    folders: tuple[str, ...] = ()


class ResultsFolder:
    """An open folder of results; it is created if it is missing.

    Args:
        path: path of the folder.
        layout: the names in it.
        mark: JSON that must be the same to continue, such as that of `mark_of`.

    Raises:
        UsageError: the folder cannot be used, is in use, or belongs to another computation.
    """

    def __init__(self, path: Path, layout: ResultsLayout, mark: Mapping[str, object]) -> None:
        self._path, self._layout, self._mark = path, layout, dict(mark)
        with ExitStack() as stack:
            folder = _opened(the_folder(path), os.O_DIRECTORY, stack)
            if not lock(folder):
                raise UsageError(
                    "Another process is writing to this folder.", where=str(path), todo=f"Wait for its end. {ELSEWHERE}"
                )  # fmt: skip
            self._written = self._checked_mark()
            self._save_mark()
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW
            self._fd = _opened(path / layout.lines, flags, stack)
            self._open = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def lines(self, shape: TypeAdapter[T]) -> Iterator[tuple[str, T]]:
        """Yield each result with its place, ``FILE:LINE``; remove a truncated last line.

        Raises:
            UsageError: a line does not fit, or the file cannot be read.
        """
        path, end = self._path / self._layout.lines, 0
        with os_errors("The file cannot be read", path):
            with path.open("rb") as file:
                for number in count(1):
                    line = file.readline(MOST_LINE)
                    if not line.endswith(b"\n"):
                        break
                    yield f"{path}:{number}", self._valid(line, shape, f"{path}:{number}")
                    end += len(line)
            if len(line) == MOST_LINE:
                raise self.misfit(f"It has more than {MOST_LINE} bytes.", f"{path}:{number}")
            if line:
                os.ftruncate(self._fd, end)

    def by_key(self, shape: TypeAdapter[T], key: Callable[[T, str], K], noun: str) -> dict[K, T]:
        """Return the results by their keys, which ``key`` gives from a result and its place; a key is there once.

        Raises:
            UsageError: see `lines`; or the ``noun`` of a line is in an earlier one, too.
        """
        done: dict[K, T] = {}
        for where, result in self.lines(shape):
            if (found := key(result, where)) in done:
                raise self.misfit(f"its {noun} is in an earlier line, too.", where)
            done[found] = result
        return done

    def misfit(self, what: str, where: str) -> UsageError:
        """Return the error about a line that does not fit."""
        return UsageError(
            f"This line is not a result of this {self._layout.noun}: {what}",
            where=where,
            todo=f"{self._layout.todo} Or name another folder with -o.",
        )

    def append(self, result: Mapping[str, object]) -> None:
        """Write a line, completely or not at all; raises UsageError."""
        path = self._path / self._layout.lines
        with os_errors(
            "The file cannot be written",
            path,
            todo="Its lines are whole: repeat the command with the same folder.",
        ):
            append_whole(self._fd, json.dumps(result).encode() + b"\n")

    def read(self, name: str) -> bytes | None:
        """Return the content of one of the folder's files, None if it is missing; raises UsageError."""
        path = self._path / name
        with os_errors("The file cannot be read", path, todo=ELSEWHERE):
            return path.read_bytes() if _is_there(path) else None

    def write(self, name: str, data: bytes, *, keep: bool = False) -> Path | None:
        """Write one of the folder's files; return the ``NAME-1``, … under which an edited old file is kept.

        Args:
            name: one of the names in the layout.
            data: its new content.
            keep: keep the old file even if it was not edited.

        Raises:
            UsageError: the file cannot be written; the old file is unchanged.
        """
        path, beside, old = self._path / name, None, self.read(name)
        if old not in (None, data) and (keep or _digest(old or b"") != self._written.get(name)):
            names = (path.with_name(f"{path.stem}-{number}{path.suffix}") for number in count(1))
            beside = next(each for each in names if not os.path.lexists(each))
            with os_errors(f"The file cannot be kept as {beside.name}", path, todo="Move it away."):
                os.link(path, beside)
        write_whole(path, data)
        self._written[name] = _digest(data)
        self._save_mark()
        return beside

    def _valid(self, line: bytes, shape: TypeAdapter[T], where: str) -> T:
        try:
            return shape.validate_json(line, strict=True)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False, include_input=False)[0]
            at = ".".join(map(str, first["loc"]))
            raise self.misfit(
                printable(f"{at}: {first['msg']}." if at else f"{first['msg']}.", 200), where
            ) from None

    def _checked_mark(self) -> dict[str, str]:
        """Return the digests of the written files; raise UsageError, before hours of work, if the folder
        does not fit.
        """
        layout, path = self._layout, self._path / self._layout.mark
        found = [name for name in (layout.lines, *layout.files) if _is_there(self._path / name)]
        found += [name for name in layout.folders if _is_there(self._path / name, folder=True)]
        if not _is_there(path):
            if found:
                raise UsageError(
                    f"This folder holds {found[0]} and no {layout.mark}: no {layout.noun} wrote it.",
                    where=str(self._path), todo=ELSEWHERE,
                )  # fmt: skip
            return {}
        with os_errors("The file cannot be read", path, todo=ELSEWHERE), path.open("rb") as file:
            content = file.read(MOST_MARK)
        try:
            mark = json.loads(content)
        except (ValueError, RecursionError):
            mark = None
        if not isinstance(mark, dict):
            raise UsageError(f"This is not a mark of a {layout.noun}.", where=str(path), todo=ELSEWHERE)
        for key, value in self._mark.items():
            if mark.get(key) != value:
                raise UsageError(
                    f"This folder has the {layout.noun} of another {_WORDS.get(key, key)}.",
                    where=str(self._path), todo=ELSEWHERE,
                )  # fmt: skip
        written = mark.get(WRITTEN)
        return {name: str(written[name]) for name in written} if isinstance(written, dict) else {}

    def _save_mark(self) -> None:
        content = json.dumps(self._mark | {WRITTEN: self._written}, indent=1) + "\n"
        write_whole(self._path / self._layout.mark, content.encode())


def _opened(path: Path, flags: int, stack: ExitStack) -> int:
    with os_errors("It cannot be opened", path, todo=ELSEWHERE):
        fd = os.open(path, flags | os.O_CLOEXEC, 0o666)
    stack.callback(os.close, fd)
    return fd


def _is_there(path: Path, *, folder: bool = False) -> bool:
    """Return whether the file, or folder, exists; raises UsageError if the path is a link or of another type."""
    if not os.path.lexists(path):
        return False
    mode = os.lstat(path).st_mode
    if not (stat.S_ISDIR(mode) if folder else stat.S_ISREG(mode)):
        raise UsageError(
            f"This is not a {'folder' if folder else 'file'}.",
            where=str(path),
            todo=f"Move it away. {ELSEWHERE}",
        )
    return True


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()
