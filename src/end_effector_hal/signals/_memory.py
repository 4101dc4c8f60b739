"""What an object remembers, as plain data, and how a new one comes to remember the same.

A recording that begins in the middle needs it. Each class names in ``MEMORY`` the attributes that change while it
works, with their types; everything else follows from the description. `PART` stands for objects that have a memory of
their own: one, None, or a list, tuple or dict of them that is the same for the same description. `INLINE` is a `PART`
whose memory stands among that of the object that has it. ``RECORDED_AS`` maps attributes to the earlier names that
recordings keep.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, ClassVar, Protocol, TypeVar

from pydantic import TypeAdapter, ValidationError

from end_effector_hal.errors import UsageError

PART: Any = object()
INLINE: Any = object()
_CHANGED_IN_PLACE = (list, dict, deque, set)


class Remembers(Protocol):
    """An object with a memory."""

    MEMORY: ClassVar[dict[str, Any]]


T = TypeVar("T", bound=Remembers)


def memory_of(thing: Remembers) -> dict[str, Any]:
    """Plain data, the same for the same memory."""
    return {
        recorded: _told(getattr(owner, name)) if kind is PART else _plain(kind, getattr(owner, name))
        for owner, name, recorded, kind in _remembered(thing)
    }


def clone(thing: T) -> T:
    """Another object that remembers the same: what one of the two goes through, the other does not.

    What is in no memory is shared by both.
    """
    new = _copied(thing)
    todo: list[Any] = [new]
    while todo:
        each = todo.pop()
        for name, kind in each.MEMORY.items():
            value = getattr(each, name)
            if kind is not PART and kind is not INLINE:
                if type(value) in _CHANGED_IN_PLACE:
                    setattr(each, name, value.copy())
            elif value is not None:
                if isinstance(value, dict):
                    fresh: Any = dict(zip(value, map(_copied, value.values()), strict=True))
                    todo += fresh.values()
                elif isinstance(value, list | tuple):
                    fresh = type(value)(map(_copied, value))
                    todo += fresh
                else:
                    fresh = _copied(value)
                    todo.append(fresh)
                setattr(each, name, fresh)
    return new


def _copied(thing: T) -> T:
    """Another object with the very same parts."""
    kind = type(thing)
    new = kind.__new__(kind)
    vars(new).update(vars(thing))
    return new


def same_memory(one: Remembers, other: Remembers) -> bool:
    """Whether two objects of the same description remember the same."""
    return all(
        _same(getattr(one, name), getattr(other, name)) if kind is PART or kind is INLINE
        else getattr(one, name) == getattr(other, name)
        for name, kind in one.MEMORY.items()
    )  # fmt: skip


def recall(thing: Remembers, memory: object, where: str = "memory") -> None:
    """Let a new object remember what another one of the same description did.

    Raises:
        UsageError: that is no memory of such an object; it may remember a part of it.
    """
    remembered = list(_remembered(thing))
    found = _same_keys(memory, [recorded for _, _, recorded, _ in remembered], where)
    for owner, name, recorded, kind in remembered:
        place = f"{where}.{recorded.lstrip('_')}"
        if kind is PART:
            _recall_part(getattr(owner, name), found[recorded], place)
            continue
        try:
            value = _adapter(kind).validate_python(found[recorded])
        except ValidationError as error:
            raise UsageError(
                f"A recorded state cannot be read: {place}: {error.errors()[0]['msg']}."
            ) from None
        setattr(owner, name, value)


def _remembered(thing: Remembers) -> Iterator[tuple[Remembers, str, str, Any]]:
    """Each attribute that is remembered: the object that has it, its name there and in a recording, its type."""
    earlier = getattr(thing, "RECORDED_AS", {})
    for name, kind in thing.MEMORY.items():
        if kind is INLINE:
            yield from _remembered(getattr(thing, name))
        else:
            yield thing, name, earlier.get(name, name), kind


def _same(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is other
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(_same(each, other[key]) for key, each in one.items())
    return same_memory(one, other)


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
