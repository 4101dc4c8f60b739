"""One device of the library: its file, read as a fragment of a description and as what documents it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
