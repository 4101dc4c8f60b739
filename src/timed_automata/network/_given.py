"""Constants that are given from outside, instead of their initialisers."""

from __future__ import annotations

from collections.abc import Sequence

from timed_automata.compiler import Type
from timed_automata.errors import UsageError

Given = int | bool | Sequence["Given"]


def flatten_given(value: Given, type_: Type, name: str) -> list[int]:
    """The scalars of a constant given from outside.

    Raises:
        UsageError: its shape, a type or a range is not that of the declaration.
    """
    if type_.dimensions:
        size = type_.dimensions[0].size
        if isinstance(value, str | int) or not isinstance(value, Sequence) or len(value) != size:
            raise UsageError(f"The constant '{name}' needs a list of {size} values, not {value!r}.")
        return [scalar for item in value for scalar in flatten_given(item, type_.element, name)]
    if not isinstance(value, int) or (isinstance(value, bool) and type_.kind != "bool"):
        raise UsageError(f"The constant '{name}' needs {type_.kind} values, not {value!r}.")
    if not type_.low <= value <= type_.high:
        raise UsageError(f"The constant '{name}' = {value} is outside of {type_.low} to {type_.high}.")
    return [int(value)]


def as_source(value: Given, type_: Type) -> str:
    """A constant in UPPAAL's language."""
    if isinstance(value, Sequence):
        return "{" + ", ".join(as_source(item, type_) for item in value) + "}"
    return ("true" if value else "false") if type_.kind == "bool" else str(int(value))
