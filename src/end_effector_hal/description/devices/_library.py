"""The library of devices: the file of one of them, read as a fragment of a description and as what documents it.

Devices are found by their name: in a folder of the user's, among the shipped ones, in other distributions.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import Field, ValidationError

from end_effector_hal.description._fault import Fault, Keys, Places
from end_effector_hal.description._shape import fields_of, stanza_at
from end_effector_hal.description.reading._yaml import Reader, read_text
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import BaseStanza, Name, Word

Confirmed = Literal["maker", "drivers", "no"]
CONFIRMED = {
    "maker": "by a document of the maker",
    "drivers": "by public drivers only, not by a document of the maker",
    "no": "by nothing that was read of this device",
}
"""What a word under ``confirmed`` means."""
Text = Annotated[Word, Field(min_length=1, max_length=400)]
Stanza = dict[str, Any]


class SourceDocument(BaseStanza):
    """A document, or the code of a public driver, that the facts of a device come from."""

    title: Text
    url: Word = ""


class DocumentedRegister(BaseStanza):
    """A register, or a row of them, and the place where it is documented."""

    address: Annotated[int, Field(ge=0, le=0xFFFF)]
    count: Annotated[int, Field(ge=1, le=125)] = 1
    what: Text
    document: Annotated[int, Field(ge=1)] = 1
    page: Word = ""
    confirmed: Confirmed | None = None


class DeviceOutput(BaseStanza):
    """One of several outputs of a device: the channels and the keys of an actuator that uses it."""

    channels: dict[Name, Stanza] = Field(default={}, max_length=64)
    actuator: Stanza = Field(default={})


class DeviceFile(BaseStanza):
    """The keys of a device's file.

    ``link``, ``channels``, ``actuator`` and ``inputs`` are stanzas of a description; they are judged where they are
    used. A device with several actuators has ``outputs``, and what all of them have in common under ``actuator``.
    """

    title: Text
    maker: Text
    summary: Word = ""
    confirmed: Confirmed
    documents: Annotated[tuple[SourceDocument, ...], Field(strict=False, min_length=1, max_length=16)]
    registers: Annotated[tuple[DocumentedRegister, ...], Field(strict=False, max_length=64)]
    not_confirmed: Annotated[tuple[Text, ...], Field(strict=False, max_length=32)] = ()
    unit: Annotated[int, Field(ge=0, le=255)] | None = None
    link: Stanza = Field(default={})
    channels: dict[Name, Stanza] = Field(default={}, max_length=64)
    actuator: Stanza = Field(default={})
    outputs: dict[Name, DeviceOutput] = Field(default={}, max_length=64)
    inputs: dict[Name, Stanza] = Field(default={}, max_length=64)

    def confirmation(self, register: DocumentedRegister) -> Confirmed:
        """Return how a register is confirmed: by its own word, else by that of the device."""
        return register.confirmed or self.confirmed


@dataclass(frozen=True)
class LibraryDevice:
    """A device of the library.

    Attributes:
        name: its name, which is that of its file.
        path: absolute path of its file.
        shown: the path as messages show it.
        origin: where it was found: ``shipped``, a folder, or the package that provides it.
        about: the keys of its file.
        places: the places of all keys and values in its file.
    """

    name: str
    path: Path
    shown: str
    origin: str
    about: DeviceFile
    places: Places

    @property
    def kind(self) -> str:
        """Kind of the actuator that it is; ``any`` for an output of an I/O board, ``inputs`` if it has no output."""
        return str(self.about.actuator.get("kind") or ("any" if self.about.outputs else "inputs"))


def read_device(path: Path, shown: str, origin: str) -> LibraryDevice | list[Fault]:
    """Read the file of a device, or return its faults, which have the name of that file."""
    text = read_text(path)
    if isinstance(text, Fault):
        return [_in_file(text, shown)]
    places = Places(path, shown)
    reader = Reader(text, places)
    tree = reader.read()
    faults = [_in_file(each, shown) for each in reader.faults]
    if faults:
        return faults
    try:
        return LibraryDevice(path.stem, path, shown, origin, DeviceFile.model_validate(tree), places)
    except ValidationError as error:
        found = error.errors(include_url=False, include_input=False)
        return [_in_file(_fault(each["loc"], each["msg"], places), shown) for each in found]


def _fault(path: tuple[int | str, ...], why: str, places: Places) -> Fault:
    what = f"{'.'.join(map(str, path)) or 'the file'}: {why[:1].lower()}{why[1:]}"
    return Fault.at(places.value(*path), "EE-230", what, found="", expected="the keys of a device")


def _in_file(fault: Fault, shown: str) -> Fault:
    return replace(fault, path=(), file=shown)


def renamed(value: Any, names: Mapping[str, str], path: Keys, kind: str) -> Any:
    """Return a copy of a value of an actuator's stanza with the names that the description has.

    Args:
        value: a value, or a whole stanza.
        names: the names in the description by those in the file.
        path: where the value stands in the description.
        kind: the kind of the actuator.
    """
    if isinstance(value, dict):
        return {key: renamed(each, names, (*path, key), kind) for key, each in value.items()}
    if isinstance(value, list):
        return [renamed(each, names, (*path, index), kind) for index, each in enumerate(value)]
    if isinstance(value, str) and value in names and not _is_choice(path, kind):
        return names[value]
    return value


def _is_choice(path: Keys, kind: str) -> bool:
    """Return whether a key allows only certain words, so that its value is not the name of a channel."""
    keys = [each for each in path if not isinstance(each, int)]
    if keys[-1] == "kind":
        return True
    try:
        stanza = stanza_at(tuple(keys[:-1]), kind)
    except UsageError:  # an unknown kind
        return False
    found = fields_of(stanza).get(str(keys[-1])) if stanza else None
    return found is not None and _has_choices(found.annotation)


def _has_choices(annotation: Any) -> bool:
    return get_origin(annotation) is Literal or any(
        _has_choices(each) for each in get_args(annotation) if not isinstance(each, str)
    )


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
