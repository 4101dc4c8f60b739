"""Messages as lines of JSON. Incoming content is limited here, so that it is safe to repeat in replies and logs."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LONGEST_SENTENCE, printable

T = TypeVar("T")


def write_json(value: object) -> bytes:
    """Return compact JSON without a line break."""
    return _ENCODER.encode(value).encode()


def read_json(content: bytes, read: Callable[[Any], T]) -> T:
    """Parse JSON and return the result of ``read`` on it.

    Raises:
        UsageError: the content is not JSON, or ``read`` does not find what it needs.
    """
    try:
        return read(json.loads(content))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise UsageError(f"unexpected JSON: {error}.") from error


DEEPEST = 4
DIGITS = 18
TOO_LARGE = 10**DIGITS
_NO_NUMBER = f"a number in a message must be an integer of at most {DIGITS} digits."
_NO_OBJECT = "a message must be a JSON object in UTF-8."


def read_message(line: bytes) -> dict[str, Any]:
    """Parse a line into an object; its sentence ``why`` is made printable.

    Raises:
        UsageError: the line is not an object, or contains a number or a text that no message needs.
    """
    try:
        given = _DECODER.decode(line.decode())
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
    """Parse a reply of the arbiter; the caller makes its texts printable. Raises UsageError."""
    return read_json(line, _object)


def write_message(message: Mapping[str, object]) -> bytes:
    """Return the line to send."""
    return write_json(message) + b"\n"


def _object(given: Any) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise UsageError(_NO_OBJECT)
    return given


def _check(message: dict[str, Any], deepest: int) -> None:
    level: list[Any] = [message]
    for _ in range(deepest):
        inside: list[Any] = []
        for value in level:
            inside += value
            if isinstance(value, dict):
                inside += value.values()
        level = []
        for value in inside:
            if isinstance(value, dict | list):
                level.append(value)
            elif type(value) is int and abs(value) >= TOO_LARGE:
                raise UsageError(_NO_NUMBER)
            elif isinstance(value, str) and not (len(value) <= LONGEST_SENTENCE and value.isprintable()):
                raise UsageError(
                    f"a text in a message may have at most {LONGEST_SENTENCE} characters, all printable."
                )
    if level:
        raise UsageError(f"a message may be nested at most {deepest} levels deep.")


def _no_number(_text: str) -> object:
    raise UsageError(_NO_NUMBER)


_ENCODER = json.JSONEncoder(separators=(",", ":"))
_DECODER = json.JSONDecoder(parse_float=_no_number, parse_constant=_no_number)
