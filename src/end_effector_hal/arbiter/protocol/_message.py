"""A message as a line of JSON. What comes in is bounded here, so that repeating it cannot harm anybody."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from end_effector_hal.arbiter._json import read_json, write_json
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LONGEST_SENTENCE, printable

LONGEST = 1 << 16
"""Bytes of a message."""
DEEPEST = 4
DIGITS = 18
_NO_OBJECT = "a message must be a JSON object in UTF-8."


def read_message(line: bytes) -> dict[str, Any]:
    """The object in a line; its sentence ``why`` is made printable.

    Raises:
        UsageError: it is not an object, or it holds a number or a text that no message needs.
    """
    try:
        given = json.loads(
            line.decode(), parse_int=_integer, parse_float=_no_number, parse_constant=_no_number
        )
    except UsageError:
        raise
    except (ValueError, RecursionError):
        raise UsageError(_NO_OBJECT) from None
    message = _object(given)
    if isinstance(why := message.get("why"), str):
        message["why"] = printable(why)
    _check(message, DEEPEST)
    return message


def read_reply(line: bytes) -> dict[str, Any]:
    """A reply of the arbiter; the caller makes its texts printable. Raises UsageError."""
    return read_json(line, _object)


def write_message(message: Mapping[str, object]) -> bytes:
    """The line to send."""
    return write_json(message) + b"\n"


def _object(given: Any) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise UsageError(_NO_OBJECT)
    return given


def _check(value: object, depth: int) -> None:
    if isinstance(value, str) and not (len(value) <= LONGEST_SENTENCE and value.isprintable()):
        raise UsageError(f"a text in a message has at most {LONGEST_SENTENCE} characters, all printable.")
    if isinstance(value, dict | list):
        if not depth:
            raise UsageError(f"a message is nested at most {DEEPEST} levels deep.")
        for each in value:
            _check(each, depth - 1)
        for each in value.values() if isinstance(value, dict) else ():
            _check(each, depth - 1)


def _integer(text: str) -> int:
    if len(text.lstrip("-")) > DIGITS:
        _no_number(text)
    return int(text)


def _no_number(_text: str) -> object:
    raise UsageError(f"a number in a message is an integer of at most {DIGITS} digits.")
