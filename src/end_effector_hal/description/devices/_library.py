"""Finds devices by their name: in a folder of the user's, among the shipped ones, in other distributions."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from end_effector_hal.description._fault import Fault

from ._device import LibraryDevice, read_device

SHIPPED = Path(__file__).resolve().parents[2] / "devices"
GROUP = "end_effector_hal.devices"
"""Entry points of other distributions; each names a package whose folder contains files of devices."""
MOST = 1000
"""Largest number of devices that are looked at in one folder."""


@dataclass(frozen=True)
class DeviceFolder:
    """A folder with files of devices, and its name in messages."""

    path: Path
    origin: str
    shown: Path

    @property
    def names(self) -> list[str]:
        """Names of its devices in alphabetical order; empty if it cannot be read."""
        try:
            files = (each for each, _ in zip(self.path.glob("*.yaml"), range(MOST), strict=False))
            return sorted(each.stem for each in files)
        except OSError:
            return []


class DeviceLibrary:
    """The devices of a description: those of its own folder precede the shipped ones, which precede all others.

    Args:
        own: folder of the user's devices; None: there is none.
        shown: that folder as messages show it.
    """

    def __init__(self, own: Path | None = None, shown: Path | None = None) -> None:
        self._folders = [DeviceFolder(own, str(shown or own), shown or own)] if own else []
        self._folders.append(DeviceFolder(SHIPPED, "shipped", SHIPPED))

    def names(self) -> list[str]:
        """Return the names of all devices in alphabetical order."""
        return sorted({name for folder in self._all() for name in folder.names})

    def meant(self, name: str) -> str:
        """Return a hint with the nearest names, such as ``did you mean 'robotiq-2f85'?``; empty: none is similar."""
        near = get_close_matches(name.lower(), self.names(), n=3)
        return f"did you mean {' or '.join(map(repr, near))}?" if near else ""

    def get(self, name: str) -> LibraryDevice | list[Fault] | None:
        """Return a device, or the faults of its file; None: there is no such device."""
        for folder in self._all():
            if name in folder.names:
                file = f"{name}.yaml"
                return read_device(folder.path / file, str(folder.shown / file), folder.origin)
        return None

    def _all(self) -> Iterator[DeviceFolder]:
        """Yield the folders in the order of precedence; those of other distributions are looked up only if needed."""
        yield from self._folders
        for entry in sorted(importlib.import_module("importlib.metadata").entry_points(group=GROUP)):
            if (path := _package(entry.module)) is not None:
                yield DeviceFolder(path, f"package {entry.module}", path)


def _package(module: str) -> Path | None:
    """Return the folder of a package without importing it; None: it is not installed."""
    top, *inside = module.split(".")
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return None
    folders = spec.submodule_search_locations if spec else None
    return Path(next(iter(folders))).joinpath(*inside) if folders else None
