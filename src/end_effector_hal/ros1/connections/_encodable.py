"""A copy of a message that can be sent whatever its texts hold: a text that cannot be encoded must not end a node."""

from __future__ import annotations

from copy import copy
from typing import Any

from end_effector_hal.vocabulary import printable

MOST = 5_000


def encodable(value: Any) -> Any:
    """A copy of a message, a list or a text in which every text can be written as UTF-8."""
    if isinstance(value, str):
        return value if _is_utf8(value) else printable(value, MOST)
    if isinstance(value, list | tuple):
        return [encodable(each) for each in value]
    if not hasattr(value, "__slots__") or not hasattr(value, "serialize"):
        return value
    made = copy(value)
    for name in value.__slots__:
        setattr(made, name, encodable(getattr(value, name)))
    return made


def _is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True
