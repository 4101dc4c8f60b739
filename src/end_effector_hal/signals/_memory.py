"""Write the state of an object as plain data, and restore it in a new object.

A recording that begins in the middle of a run needs this. Each class lists in ``MEMORY`` the attributes that change
during its work, with their types; everything else follows from the description. `NESTED` marks attributes that hold
objects with a memory of their own: one object, None, or a list, tuple or dict whose structure is the same for the same
description. The memory of an `INLINE` part is merged into that of its object.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from enum import Enum
from functools import cache
from types import UnionType
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.errors import UsageError

NESTED: Any = object()
INLINE: Any = object()
_CHANGED_IN_PLACE = (list, dict, deque, set)


class Remembers(Protocol):
    """An object with a ``MEMORY``."""

    MEMORY: ClassVar[dict[str, Any]]


T = TypeVar("T", bound=Remembers)


def memory_of(thing: Remembers) -> dict[str, Any]:
    """Return the state of an object as plain data; equal states give equal data."""
    return {
        name: _plain_nested(getattr(holder, name)) if kind is NESTED else _plain(kind, getattr(holder, name))
        for holder, name, kind in _remembered(thing)
    }


def clone(thing: T) -> T:
    """Return an independent copy of an object with the same state.

    Attributes that are not in ``MEMORY`` are shared by both.
    """
    kind = type(thing)
    new = kind.__new__(kind)
    has = vars(new)
    has.update(vars(thing))
    plan = _PLANS.get(kind)
    if plan is None:
        plan = _PLANS[kind] = _plan(thing)
        if not any(plan):
            _LEAVES.add(kind)
    for name in plan.changing:
        value = has[name]
        if type(value) in _CHANGED_IN_PLACE:
            has[name] = value.copy()
    for name in plan.parts:
        value = has[name]
        of: Any = type(value)
        if of in _LEAVES:
            has[name] = leaf = of.__new__(of)
            vars(leaf).update(vars(value))
        elif of is tuple or of is list:
            has[name] = of([clone(each) for each in value])
        elif of is dict:
            has[name] = {key: clone(each) for key, each in value.items()}
        elif value is not None:
            has[name] = clone(value)
    return new


class _Plan(NamedTuple):
    """The steps of `clone` for one class: its parts, and attributes that can be changed in place."""

    parts: tuple[str, ...]
    changing: tuple[str, ...]


_PLANS: dict[type, _Plan] = {}
_LEAVES: set[type] = set()
"""Classes without parts and without attributes that change in place: a shallow copy is enough."""


def _plan(thing: Remembers) -> _Plan:
    parts = tuple(name for name, kind in thing.MEMORY.items() if kind is NESTED or kind is INLINE)
    return _Plan(parts, tuple(name for name, kind in thing.MEMORY.items() if not _stays(kind, name in parts)))


def _stays(kind: Any, is_nested: bool) -> bool:
    """Return whether values of this declared type cannot be changed in place."""
    if is_nested or kind in (int, bool, float, str, type(None)):
        return True
    if isinstance(kind, UnionType):
        return all(_stays(each, False) for each in get_args(kind))
    return get_origin(kind) in (tuple, frozenset) or (isinstance(kind, type) and issubclass(kind, Enum))


def parts_of(thing: Remembers) -> list[Remembers]:
    """Return the parts of an object that have a memory."""
    plan = _PLANS.get(type(thing)) or _plan(thing)
    found: list[Remembers] = []
    for name in plan.parts:
        value = getattr(thing, name)
        if type(value) is dict:
            found += value.values()
        elif type(value) in (tuple, list):
            found += value
        elif value is not None:
            found.append(value)
    return found


def recall(thing: Remembers, memory: object, where: str = "memory") -> None:
    """Restore the state of another object of the same description in a new object.

    Raises:
        UsageError: the data is not the state of such an object; a part of it may already be restored.
    """
    remembered = list(_remembered(thing))
    found = _same_keys(memory, [name for _, name, _ in remembered], where)
    for holder, name, kind in remembered:
        place = f"{where}.{name.lstrip('_')}"
        if kind is NESTED:
            _recall_nested(getattr(holder, name), found[name], place)
            continue
        try:
            value = _adapter(kind).validate_python(found[name])
        except ValidationError as error:
            raise UsageError(
                f"A recorded state cannot be read: {place}: {error.errors()[0]['msg']}."
            ) from None
        setattr(holder, name, value)


def _remembered(thing: Remembers) -> Iterator[tuple[Remembers, str, Any]]:
    """Yield the attributes in the memory: the object that has the attribute, its name, its type."""
    for name, kind in thing.MEMORY.items():
        if kind is INLINE:
            yield from _remembered(getattr(thing, name))
        else:
            yield thing, name, kind


def _plain_nested(part: Any) -> Any:
    if part is None:
        return None
    if isinstance(part, list | tuple):
        return [_plain_nested(each) for each in part]
    if isinstance(part, Mapping):
        return {str(key): _plain_nested(each) for key, each in part.items()}
    return memory_of(part)


def _recall_nested(part: Any, memory: object, where: str) -> None:
    if part is None:
        if memory is not None:
            raise UsageError(f"A recorded state cannot be read: {where}: the tool has no such part.")
    elif isinstance(part, list | tuple):
        if not isinstance(memory, list) or len(memory) != len(part):
            raise UsageError(f"A recorded state cannot be read: {where}: expected are {len(part)} entries.")
        for number, (each, its) in enumerate(zip(part, memory, strict=True)):
            _recall_nested(each, its, f"{where}[{number}]")
    elif isinstance(part, Mapping):
        found = _same_keys(memory, [str(key) for key in part], where)
        for key, each in part.items():
            _recall_nested(each, found[str(key)], f"{where}[{key}]")
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
