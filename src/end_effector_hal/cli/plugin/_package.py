"""Read the package of a plug-in, a folder or a wheel, without running any of its code."""

from __future__ import annotations

import re
import tomllib
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib.metadata import EntryPoint, distributions
from pathlib import Path, PurePosixPath
from typing import Any

from end_effector_hal._extras import DISTRIBUTION
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.plugins import named

from ._check import brought

GROUP = DISTRIBUTION.replace("-", "_") + "."
"""How the groups of entry points begin that this product reads."""
MOST_FILES, MOST_MB = 1000, 50
_WORD = re.compile(r"[\w.+!-]{1,100}", re.ASCII)
_OBJECT = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*(:[A-Za-z_]\w*(\.[A-Za-z_]\w*)*)?", re.ASCII)
_SHAPE = "A plug-in is a folder with a pyproject.toml, or a wheel."
_BESIDE = (
    "A device (.yaml) or automata (.xml) of your own need no plug-in: they belong beside the description."
)
_Found = tuple[str, int, Callable[[], bytes]]


@dataclass(frozen=True)
class Package:
    """What a plug-in consists of.

    Attributes:
        name, version: of the distribution; the name is normalized.
        requires: what it depends on, as it is written.
        entries: its entry points in the groups of this product.
        files: the contents of its modules by their relative paths.
    """

    name: str
    version: str
    requires: tuple[str, ...]
    entries: tuple[EntryPoint, ...]
    files: Mapping[str, bytes]

    @property
    def brings(self) -> tuple[str, ...]:
        """Its entry points in words."""
        return tuple(map(brought, self.entries))

    @property
    def modules(self) -> tuple[str, ...]:
        """Names of the top-level modules in it."""
        return tuple(dict.fromkeys(PurePosixPath(name).parts[0].removesuffix(".py") for name in self.files))


def normalized(name: str) -> str:
    """Return the name of a distribution as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def read_package(path: Path) -> Package:
    """Return the package in a folder or a wheel.

    Raises:
        UsageError: it is no plug-in, cannot be read, or is too large.
    """
    with os_errors("The plug-in cannot be read", path):
        if path.is_dir() and (path / "pyproject.toml").is_file():
            return _folder(path)
        if path.suffix == ".whl" and path.is_file():
            try:
                with zipfile.ZipFile(path) as wheel:
                    return _wheel(path, wheel)
            except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
                raise UsageError(f"The wheel is damaged: {error}.", where=str(path)) from error
    raise UsageError(_SHAPE, where=str(path), todo=_BESIDE)


def _folder(path: Path) -> Package:
    where = path / "pyproject.toml"
    try:
        project = tomllib.loads(where.read_text(encoding="utf-8"))["project"]
        groups = project.get("entry-points", {})
        entries = [(group, *entry) for group, table in groups.items() for entry in table.items()]
        about = project["name"], project["version"], project.get("dependencies", [])
    except (ValueError, AttributeError, KeyError, TypeError) as error:
        what = f"It has no valid [project] with name and version ({named(error)})."
        raise UsageError(what, where=str(where), todo="Write both, or add a wheel.") from error
    found = _entries(entries, where)
    tops = dict.fromkeys(each.module.partition(".")[0] for each in found)
    return _package(*about, found, _collected(_copied(path, tops), where), where)


def _copied(path: Path, tops: Iterable[str]) -> Iterator[_Found]:
    """Yield the files of the modules that the entry points name: nothing is built, so no code of it runs."""
    for top in tops:
        for root in (path / "src", path):
            files = [*root.glob(f"{top}.py")] or [*(root / top).rglob("*")]
            for file in files:
                if file.is_symlink() or not (file.is_dir() or file.is_file()):
                    raise UsageError("A plug-in has only regular files.", where=str(file))
                if file.is_file() and "__pycache__" not in file.parts:
                    yield file.relative_to(root).as_posix(), file.stat().st_size, file.read_bytes
            if files:
                break


def _wheel(path: Path, wheel: zipfile.ZipFile) -> Package:
    def found() -> Iterator[_Found]:
        for info in wheel.infolist():
            parts = PurePosixPath(info.filename).parts
            outside = not parts or parts[0] == "/" or ".." in parts or not info.filename.isprintable()
            if outside or parts[0].endswith(".data"):
                what = f"The wheel has a file that belongs to no module: {info.filename!r}."
                raise UsageError(what, where=str(path))
            if not info.is_dir():
                yield info.filename, info.file_size, partial(wheel.read, info)

    files = _collected(found(), path)
    try:
        (about,) = distributions(path=[str(path)])
        points = [(each.group, each.name, each.value) for each in about.entry_points]
        name, version, requires = about.name, about.version, about.requires or ()
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise UsageError("The wheel has no valid METADATA or entry points.", where=str(path)) from error
    modules = {name: data for name, data in files.items() if ".dist-info/" not in name}
    return _package(name, version, requires, _entries(points, path), modules, path)


def _collected(found: Iterable[_Found], where: Path) -> dict[str, bytes]:
    files: dict[str, bytes] = {}
    left = MOST_MB * 1_000_000
    for name, size, read in found:
        left -= size
        if left < 0 or len(files) == MOST_FILES:
            raise UsageError(f"It has more than {MOST_FILES} files or {MOST_MB} MB.", where=str(where))
        files[name] = read()
    return files


def _entries(found: Iterable[tuple[Any, Any, Any]], where: Path) -> tuple[EntryPoint, ...]:
    """Return the entry points of this product; those of other programs are left out."""
    entries = []
    for group, name, value in found:
        if not str(group).startswith(GROUP):
            continue
        if not (
            _WORD.fullmatch(group) and _WORD.fullmatch(str(name)) and _OBJECT.fullmatch(str(value).strip())
        ):
            raise UsageError(
                f'An entry point is no NAME = "MODULE:OBJECT": {name!r}.'[:200], where=str(where)
            )
        entries.append(EntryPoint(str(name), str(value).strip(), group))
    return tuple(entries)


def _package(
    name: Any,
    version: Any,
    requires: Any,
    entries: tuple[EntryPoint, ...],
    files: Mapping[str, bytes],
    where: Path,
) -> Package:
    plain = normalized(str(name))
    if not _WORD.fullmatch(plain) or not _WORD.fullmatch(str(version)):
        raise UsageError("Its name or its version is not valid.", where=str(where))
    if not entries:
        raise UsageError(
            f'{plain} declares no entry point of this product, such as [project.entry-points."{GROUP}codecs"].',
            where=str(where),
            todo=_BESIDE,
        )
    package = Package(plain, str(version), tuple(map(str, requires)), entries, files)
    for each in entries:
        if (top := each.module.partition(".")[0]) not in package.modules:
            raise UsageError(
                f"The entry point {each.name} names the module {top}, which is not in it.", where=str(where)
            )
    return package
