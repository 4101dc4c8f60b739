"""What an object remembers, as plain data, and how a new one comes to remember the same.

A recording that begins in the middle needs it. Each class names in ``MEMORY`` the attributes that change while it
works, with their types; everything else follows from the description. `PART` stands for objects that have a memory of
their own: one, None, or a list, tuple or dict of them that is the same for the same description.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, Protocol

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.errors import UsageError

PART: Any = object()


class Remembers(Protocol):
    """An object with a memory."""

    MEMORY: ClassVar[dict[str, Any]]


def memory_of(thing: Remembers) -> dict[str, Any]:
    """Plain data, the same for the same memory."""
    return {
        name: _told(getattr(thing, name)) if kind is PART else _plain(kind, getattr(thing, name))
        for name, kind in thing.MEMORY.items()
    }


def recall(thing: Remembers, memory: object, where: str = "memory") -> None:
    """Let a new object remember what another one of the same description did.

    Raises:
        UsageError: that is no memory of such an object; it may remember a part of it.
    """
    found = _same_keys(memory, thing.MEMORY, where)
    for name, kind in thing.MEMORY.items():
        place = f"{where}.{name.lstrip('_')}"
        if kind is PART:
            _recall_part(getattr(thing, name), found[name], place)
            continue
        try:
            value = _adapter(kind).validate_python(found[name])
        except ValidationError as error:
            raise UsageError(
                f"A recorded state cannot be read: {place}: {error.errors()[0]['msg']}."
            ) from None
        setattr(thing, name, value)


def _told(part: Any) -> Any:
    if part is None:
        return None
    if isinstance(part, list | tuple):
        return [_told(each) for each in part]
    if isinstance(part, Mapping):
        return {str(key): _told(each) for key, each in part.items()}
    return memory_of(part)


def _recall_part(part: Any, memory: object, where: str) -> None:
    if part is None:
        if memory is not None:
            raise UsageError(f"A recorded state cannot be read: {where}: the tool has no such part.")
    elif isinstance(part, list | tuple):
        if not isinstance(memory, list) or len(memory) != len(part):
            raise UsageError(f"A recorded state cannot be read: {where}: expected are {len(part)} entries.")
        for number, (each, told) in enumerate(zip(part, memory, strict=True)):
            _recall_part(each, told, f"{where}[{number}]")
    elif isinstance(part, Mapping):
        found = _same_keys(memory, [str(key) for key in part], where)
        for key, each in part.items():
            _recall_part(each, found[str(key)], f"{where}[{key}]")
    else:
        recall(part, memory, where)


def _same_keys(memory: object, expected: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(memory, Mapping) or set(memory) != set(expected):
        names = ", ".join(str(key).lstrip("_") for key in expected)
        raise UsageError(f"A recorded state cannot be read: {where}: expected is an object with {names}.")
    return memory


def _plain(kind: Any, value: object) -> Any:
    plain = _adapter(kind).dump_python(value, mode="json")
    return sorted(plain) if isinstance(value, frozenset) else plain


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
