"""Reads a file as a description, or finds every fault that it has."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from end_effector_hal.description._fault import Fault, Keys, Places
from end_effector_hal.description._shape import Facts, actuator_stanzas, fields_of
from end_effector_hal.description.devices._expand import expand
from end_effector_hal.description.model._description import Description
from end_effector_hal.description.rules._declared import channel_faults
from end_effector_hal.description.rules._frames import frame_faults
from end_effector_hal.description.rules._outputs import output_faults
from end_effector_hal.description.rules._parts import activation_faults, part_faults, whole_parts
from end_effector_hal.description.rules._shared import shared_faults
from end_effector_hal.description.rules._stanzas import limit_faults, order_faults, rule_faults
from end_effector_hal.errors import DescriptionError, Diagnostic

from ._explain import explain, likely_kind, meant, no_kind, why_not
from ._likely import likely, read_as_meant
from ._yaml import Reader, read_text


@dataclass(frozen=True)
class Examination:
    """The result of reading a file: a description, or faults in the order of the file.

    Attributes:
        name: the file's name as it was given.
        description: the description; None if there are faults.
        faults: the faults, in the order of the file.
        text: the text that was read; empty if the file could not be read.
        likely: the description, with defaults in the place of faulty values, so that the rest can be judged all the
            same; None if too little is left.
    """

    name: str
    description: Description | None
    faults: tuple[Fault, ...]
    text: str = field(default="", repr=False)
    likely: Description | None = field(default=None, repr=False)
    _broken: frozenset[Keys] = field(default=frozenset(), repr=False)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The faults with the name of their file."""
        return tuple(fault.diagnostic(self.name) for fault in self.faults)

    def lines(self) -> list[str]:
        """Return the faults as lines, ready to print."""
        return [str(each) for each in self.diagnostics]

    def is_broken(self, *path: str | int) -> bool:
        """Return whether a key, its value or a stanza around it has a fault, so that it cannot be judged."""
        return any(path[:length] in self._broken for length in range(1, len(path) + 1))


def examine(path: str | Path) -> Examination:
    """Read a file; its content never makes this function raise."""
    text = read_text(Path(path))
    if isinstance(text, Fault):
        return Examination(str(path), None, (text,))
    return examine_text(text, path)


def examine_text(text: str, path: str | Path) -> Examination:
    """Examine a text that came from ``path``; files that the text names are looked for beside ``path``."""
    places = Places(Path(path).absolute(), str(path))
    likely, faults, broken = _examine(text, places)
    found = tuple(sorted(set(faults)))
    return Examination(str(path), None if faults else likely, found, text, likely, frozenset(broken))


def _examine(text: str, places: Places) -> tuple[Description | None, list[Fault], set[Keys]]:
    """Return the description that the text means or probably means, its faults, and the paths with faults."""
    reader = Reader(text, places)
    tree, faults = reader.read(), reader.faults
    if any(fault.code == "EE-202" for fault in faults):
        return None, faults, set()
    if tree is None:
        empty = Fault(0, 0, "EE-201", "the file is empty", "", "a description", "eehal schema lists its keys")
        return None, faults or [empty], set()
    if not isinstance(tree, dict):
        what = Fault.at(places.value(), "EE-203", "this is not a description", expected="keys with values")
        return None, [*faults, what], set()
    faults += read_as_meant(tree, places)
    expansion = expand(tree, places)
    faults += expansion.faults
    refused = reader.refused | expansion.refused
    broken = set(refused)
    plain = _plain_outputs(tree) | expansion.unusable
    kinds, guessed = _kinds(tree, places, broken, expansion.unusable)
    description, found = _validate(tree, places, broken)
    faults += [
        *kinds,
        *(fault for path, fault in found if not _follows(path, fault, refused, guessed, plain)),
    ]
    facts = Facts(tree, places, broken)
    faults += [fault for rule in _RULES for fault in rule(facts)]
    of_parts = [*part_faults(facts), *_of_parts(facts, refused, description)]
    broken |= {("actuators", name) for name in guessed}
    if not set(of_parts) <= set(faults):
        faults += of_parts
        tree = {key: value for key, value in tree.items() if key != "parts"}
    return likely(tree, places, broken) if faults else description, faults, broken


_RULES = (limit_faults, order_faults, rule_faults, shared_faults, frame_faults, channel_faults, output_faults)


def _of_parts(facts: Facts, refused: set[Keys], description: Description | None) -> list[Fault]:
    """Return the faults that a tool has as it grips each of its parts, apart from those that it has anyway."""
    faults: list[Fault] = []
    for part in whole_parts(facts):
        broken = set(facts.broken)
        changed, found = _validate(part.tree, part.places, broken)
        faults += activation_faults(description, changed) if description and changed else []
        faults += [fault for path, fault in found if not _follows(path, fault, refused, set(), set())]
        faults += [fault for rule in _RULES for fault in rule(Facts(part.tree, part.places, broken))]
    return faults


def _kinds(
    tree: dict[str, Any], places: Places, broken: set[Keys], unusable: set[str]
) -> tuple[list[Fault], set[str]]:
    """Return faults in kinds of actuators, and the names of actuators whose kind is a guess.

    The likely kind is inserted into the tree, so that the rest of the stanza is examined too. The kind of an actuator
    whose device is unusable is not known either, and is no fault of its own.
    """
    faults: list[Fault] = []
    guessed: set[str] = set()
    actuators = tree.get("actuators")
    for name, stanza in actuators.items() if isinstance(actuators, dict) else ():
        if isinstance(stanza, dict) and why_not(stanza.get("kind")):
            if name not in unusable:
                faults.append(no_kind(name, stanza, places))
            broken.add(("actuators", name, "kind"))
            stanza["kind"], sure = likely_kind(stanza)
            guessed |= set() if sure and name not in unusable else {name}
    return faults, guessed


def _validate(
    tree: dict[str, Any], places: Places, broken: set[Keys]
) -> tuple[Description | None, list[tuple[Keys, Fault]]]:
    try:
        description = Description.model_validate(tree, by_alias=True, by_name=False)
    except ValidationError as error:
        kinds = dict(Facts(tree, places).actuators())
        errors = error.errors(include_url=False)
        wrong = {each["loc"][:-1] for each in errors}
        # pydantic counts only the elements that are right: such a list is not empty
        errors = [each for each in errors if not (each["type"] == "too_short" and each["loc"] in wrong)]
        explained = [explain(each, places, kinds) for each in errors]
    else:
        description._places = places
        return description, []
    broken |= {path for path, _ in explained}
    broken |= {path for each in explained for path in meant(*each) if path not in places.keys}
    hinted = {(path[:-1], fault.hint) for path, fault in explained if fault.code == "EE-205"}
    # A misspelt key is one fault, not two: what it means is not missing as well.
    return None, [
        (path, fault)
        for path, fault in explained
        if not (fault.code == "EE-206" and (path[:-1], f"did you mean {path[-1]!r}?") in hinted)
    ]


def _plain_outputs(tree: dict[str, Any]) -> set[str]:
    """Return the names under ``actuators`` that were meant as outputs: they lack the keys of an actuator."""
    actuators = tree.get("actuators")
    stanzas = actuators.items() if isinstance(actuators, dict) else ()
    return {name for name, each in stanzas if isinstance(each, dict) and each.get("kind") == "output"}


def _follows(path: Keys, fault: Fault, refused: set[Keys], guessed: set[str], plain: set[str]) -> bool:
    """Return whether a fault is only a consequence of a reported one: a refused value, or a guessed kind."""
    if any(path[: len(each)] == each for each in refused):
        return True
    if path[0] == "actuators" and len(path) > 1:
        if fault.code == "EE-206" and path[1] in plain:
            return True
        # what one kind needs, where the kind is a guess
        of_a_kind = fault.code == "EE-225" if len(path) == 2 else fault.code == "EE-206" and len(path) == 3
        if of_a_kind and path[1] in guessed and not _every_kind_needs(path[-1]):
            return True
    stanzas = actuator_stanzas().values() if fault.code == "EE-205" else ()
    own_key = any(str(path[-1]) in fields_of(stanza) for stanza in stanzas)
    return own_key and path[0] == "actuators" and path[1] in guessed


def _every_kind_needs(key: str | int) -> bool:
    fields = (fields_of(stanza).get(str(key)) for stanza in actuator_stanzas().values())
    return all(each is not None and each.is_required() for each in fields)


def load(path: str | Path) -> Description:
    """Read a description.

    Raises:
        DescriptionError: the file cannot be read, or is not a valid description. ``faults`` contains every fault, in
            the order of the file: ``file:line:column: what (offending text), expected …; hint [code]``.
    """
    examination = examine(path)
    if examination.description is None:
        raise DescriptionError(examination.diagnostics)
    return examination.description
