"""Every value of a record, changed in one way after the other."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any

Path = tuple[str | int, ...]


def flips(content: dict[str, Any]) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Where it was changed, and the content then: other values, what is left out, what stands twice, another order."""
    for path in _paths(content):
        parent, key = _inner(content, path[:-1]), path[-1]
        value = parent[key]
        for other in _others(value):
            yield path, _edited(content, path, other)
        without = deepcopy(content)
        del _inner(without, path[:-1])[key]
        yield path, without
        if isinstance(parent, list):
            yield path, _edited(content, path[:-1], [*parent, value])
        if isinstance(value, list) and value != value[::-1]:
            yield path, _edited(content, path, value[::-1])


def _paths(content: Any, path: Path = ()) -> Iterator[Path]:
    pairs = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in pairs:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from _paths(value, (*path, key))


def _inner(content: Any, path: Path) -> Any:
    for key in path:
        content = content[key]
    return content


def _edited(content: dict[str, Any], path: Path, value: object) -> dict[str, Any]:
    edited = deepcopy(content)
    _inner(edited, path[:-1])[path[-1]] = value
    return edited


def _others(value: object) -> list[object]:
    """Of the same type."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value - 1]
    if isinstance(value, str):
        return [f"{value}x", *([""] if value else [])]
    return [0, 1_000_000] if value is None else []
