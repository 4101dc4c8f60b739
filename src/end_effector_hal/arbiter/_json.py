"""JSON as the arbiter writes and reads it, in messages and in records."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeVar

from end_effector_hal.errors import UsageError

T = TypeVar("T")


def write_json(value: object) -> bytes:
    """Compact, without a line break."""
    return json.dumps(value, separators=(",", ":")).encode()


def read_json(content: bytes, read: Callable[[Any], T]) -> T:
    """What ``read`` makes of the content.

    Raises:
        UsageError: it is not JSON, or ``read`` does not find in it what it looks for.
    """
    try:
        return read(json.loads(content))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise UsageError(f"this is not the JSON that was expected: {error}.") from error
