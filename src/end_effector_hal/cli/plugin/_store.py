"""The folder of plug-ins in an environment: one folder for each, beside what the package manager replaces."""

from __future__ import annotations

import compileall
import shutil
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib.machinery import PathFinder
from importlib.metadata import Distribution, distributions, entry_points
from pathlib import Path

from end_effector_hal import plugins
from end_effector_hal._extras import DISTRIBUTION
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.owned import owned_folder

from ._check import brought, faults
from ._package import Package, normalized, read_package
from ._requirement import unmet


@dataclass(frozen=True)
class Added:
    """A plug-in of this environment; ``fault`` says why it cannot be used, empty: it can."""

    name: str
    version: str
    brings: tuple[str, ...]
    fault: str


def add(path: Path) -> Package:
    """Put the plug-in of a folder or a wheel into this environment; one of the same name is replaced.

    Raises:
        UsageError: it is no plug-in, hides something that is there, lacks something, or cannot be loaded.
    """
    package = read_package(path)
    if sys.prefix == sys.base_prefix:
        raise UsageError(
            f"{sys.prefix} is no environment of its own.",
            todo="Use the Debian package, or a venv: python3 -m venv.",
        )
    _refuse(package, path)
    with _written():
        staged = owned_folder(plugins.FOLDER) / f".{package.name}.new"
        shutil.rmtree(staged, ignore_errors=True)
        _write(package, staged)
    if found := faults(staged):
        shutil.rmtree(staged, ignore_errors=True)
        raise UsageError(" ".join(found.values()), where=str(path), todo="Nothing was changed.")
    _replace(package.name, staged)
    return package


def remove(name: str) -> str:
    """Remove a plug-in, and return its name.

    Raises:
        UsageError: none has this name, or it cannot be removed.
    """
    plain, known = normalized(name), [folder.name for folder in plugins.added_folders()]
    if plain not in known:
        raise UsageError(f"There is no plug-in {name!r}.", todo=f"There are: {', '.join(known) or 'none'}.")
    _replace(plain)
    return plain


def added() -> Iterator[Added]:
    """Yield every plug-in; each is loaded, which runs its code."""
    own = _own_points()
    for folder in plugins.added_folders():
        for found in distributions(path=[str(folder)]):
            hidden = [brought(each) for each in found.entry_points if (each.group, each.name) in own]
            brings, lacking = tuple(map(brought, found.entry_points)), unmet(found.requires or ())
            if hidden:
                fault = f"{DISTRIBUTION} has {', '.join(hidden)} of its own."
            else:
                fault = f"It needs {lacking}." if lacking else " ".join(faults(folder).values())
            yield Added(folder.name, found.version, brings, fault)
            break
        else:
            yield Added(folder.name, "", (), "This folder is no plug-in: remove it.")


def _own_points() -> set[tuple[str, str]]:
    return {(each.group, each.name) for each in Distribution.from_name(DISTRIBUTION).entry_points}


def _refuse(package: Package, path: Path) -> None:
    """Refuse what would hide, or be hidden by, something that is there, or lacks something."""
    groups = {group for group, _ in _own_points()}
    plugins.added_folders()  # those are searched, too
    for entry in package.entries:
        if entry.group not in groups:
            raise UsageError(f"There is no group of entry points {entry.group}.", where=str(path))
        for other in entry_points(group=entry.group, name=entry.name):
            if other.dist and normalized(other.dist.name) != package.name:
                raise UsageError(
                    f"{other.dist.name} has a {brought(entry)} already.",
                    where=str(path),
                    todo="Choose another name.",
                )
    own = plugins.FOLDER / package.name
    elsewhere = [each for each in sys.path if Path(each) != own]
    if any(normalized(each.name) == package.name for each in distributions(path=elsewhere)):
        raise UsageError(f"{package.name} is installed already, not as a plug-in.", where=str(path))
    for module in package.modules:
        if module in sys.builtin_module_names or PathFinder.find_spec(module, elsewhere):
            raise UsageError(
                f"There is a module {module} already.", where=str(path), todo="Choose another name."
            )
    if lacking := unmet(package.requires):
        raise UsageError(
            f"{package.name} needs {lacking}.",
            where=str(path),
            todo=f"Install it into {sys.prefix}, or as a package of Debian if the environment uses those.",
        )


def _write(package: Package, staged: Path) -> None:
    """Write a plug-in that every user may read, compiled."""
    about = [f"Name: {package.name}", f"Version: {package.version}"]
    about += [f"Requires-Dist: {' '.join(each.split())}" for each in package.requires]
    points = "".join(f"[{each.group}]\n{each.name} = {each.value}\n" for each in package.entries)
    info = f"{package.name.replace('-', '_')}-{package.version}.dist-info"
    own = {"METADATA": "\n".join(["Metadata-Version: 2.1", *about, ""]), "entry_points.txt": points}
    for name, data in {**package.files, **{f"{info}/{key}": own[key].encode() for key in own}}.items():
        (file := staged / name).parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    compileall.compile_dir(
        staged, quiet=2, stripdir=str(staged), prependdir=str(plugins.FOLDER / package.name)
    )
    for each in (staged, *staged.rglob("*")):
        each.chmod(0o755 if each.is_dir() else 0o644)


def _replace(name: str, staged: Path | None = None) -> None:
    """Put a written folder into the place of a plug-in; None: nothing. A half of a plug-in is never in its place."""
    with _written():
        final, old = plugins.FOLDER / name, plugins.FOLDER / f".{name}.old"
        shutil.rmtree(old, ignore_errors=True)
        if final.exists():
            final.rename(old)
        if staged is not None:
            staged.rename(final)
        shutil.rmtree(old, ignore_errors=True)


def _written() -> AbstractContextManager[None]:
    return os_errors(
        "Plug-ins cannot be written", plugins.FOLDER, todo="Use the user of the environment: sudo eehal …"
    )
