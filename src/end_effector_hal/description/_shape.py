"""The keys that a stanza may have, and access to the valid values of a description that still has faults."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from end_effector_hal.description.model._channels import Channel
from end_effector_hal.description.model._description import Description
from end_effector_hal.description.model._stanzas import GrippedPart, Link, PlainOutput
from end_effector_hal.kinds import get_kind, usable_kinds
from end_effector_hal.kinds.stanza import Actuator, BaseStanza, Condition

from ._fault import Fault, Keys, Places

MAPPINGS: dict[str, type[BaseStanza]] = {
    "links": Link,
    "channels": Channel,
    "parts": GrippedPart,
    "outputs": PlainOutput,
}
"""Stanzas that stand under names chosen by the user."""
_KIND = re.compile(r"<\w+>")


def fields_of(model: type[BaseStanza]) -> dict[str, FieldInfo]:
    """Return the fields of a stanza by their key in the file."""
    return {each.alias or name: each for name, each in model.model_fields.items()}


def actuator_stanzas() -> dict[str, type[Actuator]]:
    """Return the stanza of each kind of actuator."""
    return {name: kind.stanza for name, kind in usable_kinds().items()}


def stanza_at(path: tuple[str | int, ...], kind: str) -> type[BaseStanza] | None:
    """Return the model of the stanza at a path; None: none is possible. ``kind``: that of an actuator."""
    model: type[BaseStanza] | None = Description
    if len(path) >= 2 and path[0] == "actuators":
        model, path = get_kind(kind).stanza, path[2:]
    elif len(path) >= 2 and path[0] in MAPPINGS:
        model, path = MAPPINGS[str(path[0])], path[2:]
    for key in path:
        if isinstance(key, int):
            continue  # an element of a list is of the stanza that the list is of
        field = fields_of(model).get(str(key)) if model else None
        model = stanza_in(field.annotation) if field else None
    return model


def stanza_in(annotation: Any) -> type[BaseStanza] | None:
    """Return the stanza in an annotation such as ``ToolChanger | None`` or of a list, not of a dictionary."""
    if isinstance(annotation, type) and issubclass(annotation, BaseStanza):
        return annotation
    if get_origin(annotation) is dict:
        return None
    return next(filter(None, map(stanza_in, get_args(annotation))), None)


def top_mappings() -> dict[str, list[type[BaseStanza]]]:
    """Return the top-level keys with stanzas under the user's own names, and the models of these stanzas."""
    return {**{key: [model] for key, model in MAPPINGS.items()}, "actuators": [*actuator_stanzas().values()]}


def homes_of(key: str, value: Any) -> list[str]:
    """Return the stanzas that have this key, as ``link`` or ``actuators.<name>``.

    An actuator's stanza has the kind in place of the name if only one kind has the key.

    Keys that accept only a few words are left out if the value is a number.
    """
    found = {stanza: fields_of(model).get(key) for stanza, model in stanzas().items()}
    homes = [
        stanza
        for stanza, each in found.items()
        if each and not (isinstance(value, int | float) and get_origin(each.annotation) is Literal)
    ]
    return list(dict.fromkeys(of_any_kind(each) if is_common(each, homes) else each for each in homes))


def is_common(stanza: str, among: Collection[str] | None = None) -> bool:
    """Return whether every kind of actuator has this stanza."""
    return stanza.startswith("actuators.<") and all(
        _KIND.sub(f"<{kind}>", stanza, count=1) in (among or stanzas()) for kind in usable_kinds()
    )


def of_any_kind(stanza: str) -> str:
    """Return ``actuators.<name>.endings`` for ``actuators.<vacuum>.endings``."""
    return _KIND.sub("<name>", stanza, count=1)


def stanzas() -> dict[str, type[BaseStanza]]:
    """Return every stanza by its dotted path; the path of the whole description is ``""``."""
    found: dict[str, type[BaseStanza]] = {}

    def walk(path: str, model: type[BaseStanza]) -> None:
        found[path] = model
        if model is Condition:
            return  # conditions in conditions have the same keys
        for key, each in fields_of(model).items():
            below = f"{path}.{key}" if path else key
            if inner := stanza_in(each.annotation):
                walk(below, inner)
            elif below == "actuators":
                for kind, actuator in actuator_stanzas().items():
                    walk(f"actuators.<{kind}>", actuator)
            elif below in ("channels", "parts", "outputs"):
                walk(f"{below}.<name>", MAPPINGS[below])

    walk("", Description)
    return found


@dataclass(frozen=True)
class Facts:
    """A tree of values, their places, and the paths that already have a fault."""

    tree: dict[str, Any]
    places: Places
    broken: set[Keys] = field(default_factory=set)

    def fault(self, path: Keys, code: str, what: str, expected: str = "", **more: str) -> Fault:
        """Return a fault at a value; ``more``: the ``hint``, and what is ``found`` if that is not its text."""
        return Fault.at(self.places.value(*path), code, what, expected=expected, **more)

    def key_fault(self, path: Keys, code: str, what: str, expected: str = "", **more: str) -> Fault:
        """Return a fault at a key, whatever its value is: what is found is the key, unless ``more`` says otherwise."""
        more = {"found": str(path[-1]), **more}
        return Fault.at(self.places.key(*path), code, what, expected=expected, **more)

    def written(self, *path: str | int) -> bool:
        """Return whether the key is written in the file."""
        return path in self.places.values

    def get(self, *path: str | int) -> Any:
        """Return the value, or the default if it is not written; None: it is faulty or unknown."""
        if any(path[:length] in self.broken for length in range(len(path) + 1)):
            return None
        value: Any = self.tree
        for key in path:
            if not isinstance(value, dict) or key not in value:
                return self.default(path)
            value = value[key]
        return value

    def says(self, *path: str | int) -> bool:
        """Return whether a key is written with another value than its default.

        The default itself does not count, because a recorded description writes defaults, too.
        """
        if path in self.broken:
            return self.written(*path)
        return self.written(*path) and self.get(*path) != self.default(path)

    def broken_within(self, *path: str | int) -> bool:
        """Return whether a stanza already contains a fault, which may cause others."""
        return any(each[: len(path)] == path for each in self.broken)

    def unbroken(self, *path: str | int) -> Any:
        """Return a list; None if it is not written, or one of its elements is faulty."""
        return None if self.broken_within(*path) else self.get(*path)

    def default(self, path: Keys) -> Any:
        """Return the default of a key; None if it has none."""
        stanza = stanza_at(path[:-1], self._kind(path))
        found = fields_of(stanza).get(str(path[-1])) if stanza else None
        return None if found is None or found.is_required() else found.default

    def _kind(self, path: Keys) -> str:
        return (
            str(self.tree["actuators"][path[1]]["kind"]) if path[0] == "actuators" and len(path) > 2 else ""
        )

    def names(self, *path: str | int) -> list[str]:
        """Return the elements of a list of texts, or the keys of a mapping; empty if it is faulty."""
        value = self.get(*path)
        return [str(each) for each in value or ()]

    def actuators(self) -> list[tuple[str, str]]:
        """Return name and kind of each actuator whose stanza can be read."""
        stanzas = self.tree.get("actuators")
        if not isinstance(stanzas, dict):
            return []
        return [(name, each["kind"]) for name, each in stanzas.items() if isinstance(each, dict)]

    def outputs(self) -> list[Keys]:
        """Return the keys of every output that is written and whose stanza can be read."""
        kinds = [(name, get_kind(kind).opposing) for name, kind in self.actuators()]
        found: list[Keys] = [("tool_changer",), *(("actuators", name) for name, _ in kinds)]
        found += [("actuators", name, opposing) for name, opposing in kinds if opposing]
        found += [("outputs", name) for name in self.names("outputs")]
        return [each for each in found if self.written(*each) and isinstance(self.get(*each), dict)]
