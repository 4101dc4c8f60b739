"""A folder of results: locked while it is written, marked with what it belongs to, and read with distrust.

Rule 1: One process writes in it at a time.
Rule 2: It has a mark, a file that says what it belongs to. Without one, or with another one, a folder that holds a file
    of these names is refused: somebody else's files are never taken for results.
Rule 3: Each result is a line of JSON, written whole or not at all. A last line that a kill has cut off goes; any other
    line that does not fit is an error with its number.
Rule 4: The other files are written whole or not at all. One that somebody has changed since stays beside it.
Rule 5: Links are not followed.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Self, TypeVar

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.cli import the_folder, write_whole
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import append_whole, lock
from end_effector_hal.vocabulary import printable

T = TypeVar("T")

MOST_LINE, MOST_MARK, MOST_FILE = 4_000_000, 100_000, 64_000_000
"""Bytes of a line, of the mark, and of a file that is read again."""
WRITTEN = "written"
ELSEWHERE = "Name another folder with -o."
_WORDS = {
    "automata": "UPPAAL file",
    "keys": "set of keys",
    "version": "version of the program",
    "source": "state of the program's source",
}


@dataclass(frozen=True)
class ResultsLayout:
    """Names in a folder of results.

    Attributes:
        noun: of the computation, such as ``matrix``.
        mark, lines: files that say what the folder belongs to, and that hold the results.
        todo: what to do about a line that does not fit.
        files, folders: the others that the computation writes.
    """

    noun: str
    mark: str
    lines: str
    todo: str
    files: tuple[str, ...] = ()
    folders: tuple[str, ...] = ()


class ResultsFolder:
    """An open folder of results; it is made if there is none.

    Args:
        path: of the folder.
        layout: the names in it.
        mark: what must be the same to go on, such as `mark_of` makes it; JSON.

    Raises:
        UsageError: it cannot be used, is in use, or belongs to something else.
    """

    def __init__(self, path: Path, layout: ResultsLayout, mark: Mapping[str, object]) -> None:
        self._path, self._layout, self._mark = path, layout, dict(mark)
        self._written: dict[str, str] = {}
        with ExitStack() as stack:
            folder = _opened(the_folder(path), os.O_RDONLY | os.O_DIRECTORY)
            stack.callback(os.close, folder)
            if not lock(folder):
                raise UsageError(
                    "Another process is writing to this folder.", where=str(path), todo=f"Wait for its end. {ELSEWHERE}"
                )  # fmt: skip
            self._check_kinds()
            self._check_mark()
            self._save_mark()
            self._fd = _opened(path / layout.lines, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW)
            stack.callback(os.close, self._fd)
            self._open = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let others use it; nothing happens the second time."""
        self._open.close()

    def lines(self, shape: TypeAdapter[T]) -> Iterator[tuple[str, T]]:
        """Each result with its place, ``FILE:LINE``; a last line that was cut off goes.

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

    def misfit(self, what: str, where: str) -> UsageError:
        """The error about a line that does not fit."""
        return UsageError(
            f"This line is not a result of this {self._layout.noun}: {what}",
            where=where,
            todo=f"{self._layout.todo} Or name another folder with -o.",
        )

    def append(self, result: Mapping[str, object]) -> None:
        """Write a line, whole or not at all; raises UsageError."""
        try:
            append_whole(self._fd, json.dumps(result).encode() + b"\n")
        except OSError as error:
            path = self._path / self._layout.lines
            raise UsageError(
                f"The file cannot be written: {error.strerror}.",
                where=str(path),
                todo="What is in it is whole; it goes on with the same folder.",
            ) from None

    def read(self, name: str) -> bytes | None:
        """One of its files; None: it is not there; raises UsageError."""
        path = self._path / name
        return _content(path, MOST_FILE) if _is_there(path, stat.S_ISREG, "file") else None

    def write(self, name: str, data: bytes, *, keep: bool = False) -> Path | None:
        """Write one of its files; what somebody has changed since stays as ``NAME-1``, …, which is returned.

        Args:
            name: of those in the layout.
            data: its new content.
            keep: the old one stays in any case.

        Raises:
            UsageError: it cannot be written; then the old one is still there.
        """
        path, beside = self._path / name, None
        digest, before = sha256(data).hexdigest(), _digest(path)
        changed = before not in (None, digest, self._written.get(name))
        if changed or (keep and before not in (None, digest)):
            beside = next(each for number in count(1) if not os.path.lexists(each := _numbered(path, number)))
            with os_errors(
                f"The file is to be kept, and cannot be as {beside.name}", path, todo="Move it away."
            ):
                os.link(path, beside)
        write_whole(path, data)
        self._written[name] = digest
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

    def _check_kinds(self) -> None:
        """Before hours of work, not behind them."""
        layout = self._layout
        for name in (layout.mark, layout.lines, *layout.files):
            _is_there(self._path / name, stat.S_ISREG, "file")
        for name in layout.folders:
            _is_there(self._path / name, stat.S_ISDIR, "folder")

    def _check_mark(self) -> None:
        layout, path = self._layout, self._path / self._layout.mark
        if not os.path.lexists(path):
            others = (layout.lines, *layout.files, *layout.folders)
            if found := [name for name in others if os.path.lexists(self._path / name)]:
                raise UsageError(
                    f"This folder holds {found[0]} and no {layout.mark}: no {layout.noun} wrote it.",
                    where=str(self._path), todo=ELSEWHERE,
                )  # fmt: skip
            return
        try:
            found_mark = json.loads(_content(path, MOST_MARK))
        except (ValueError, RecursionError):
            found_mark = None
        if not isinstance(found_mark, dict):
            raise UsageError(f"This is not a mark of a {layout.noun}.", where=str(path), todo=ELSEWHERE)
        for key, value in self._mark.items():
            if found_mark.get(key) != value:
                raise UsageError(
                    f"This folder has the {layout.noun} of another {_WORDS.get(key, key)}.",
                    where=str(self._path), todo=ELSEWHERE,
                )  # fmt: skip
        written = found_mark.get(WRITTEN)
        if isinstance(written, dict):
            self._written = {name: str(written[name]) for name in layout.files if name in written}

    def _save_mark(self) -> None:
        content = json.dumps(self._mark | {WRITTEN: self._written}, indent=1) + "\n"
        write_whole(self._path / self._layout.mark, content.encode())


def _opened(path: Path, flags: int) -> int:
    with os_errors("It cannot be opened", path, todo=ELSEWHERE):
        return os.open(path, flags | os.O_CLOEXEC, 0o666)


def _is_there(path: Path, is_kind: Callable[[int], bool], kind: str) -> bool:
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return False
    except OSError as error:
        raise UsageError(
            f"It cannot be reached: {error.strerror}.", where=str(path), todo=ELSEWHERE
        ) from None
    if not is_kind(mode):
        raise UsageError(f"This is not a {kind}.", where=str(path), todo=f"Move it away. {ELSEWHERE}")
    return True


def _content(path: Path, most: int) -> bytes:
    with os_errors("The file cannot be read", path, todo=ELSEWHERE), path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise UsageError(f"The file has more than {most} bytes.", where=str(path), todo="Move it away.")
    return data


def _digest(path: Path) -> str | None:
    """Of a file; None: there is none."""
    if not _is_there(path, stat.S_ISREG, "file"):
        return None
    return sha256(_content(path, MOST_FILE)).hexdigest()


def _numbered(path: Path, number: int) -> Path:
    return path.with_name(f"{path.stem}-{number}{path.suffix}")
