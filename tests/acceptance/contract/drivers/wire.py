"""What both drivers have in common: JSON lines, requests on standard input, answers and events on standard output."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import Any

Json = Any
AT_ONCE = 8
"""Requests that may wait for their answer."""


class Wire:
    """Standard output is for JSON lines alone: whatever else is printed goes to standard error."""

    def __init__(self) -> None:
        self._out = os.fdopen(os.dup(1), "w", encoding="utf-8")
        self._lock = threading.Lock()
        os.dup2(2, 1)

    def event(self, of: int, kind: str, **said: Json) -> None:
        """Something came for a handle that a request has made."""
        self._write({"of": of, "kind": kind, "at": time.monotonic(), **said})

    def serve(self, operations: Mapping[str, Callable[..., Json]]) -> None:
        """Carry out requests until standard input ends; an error is an answer, too."""
        with ThreadPoolExecutor(AT_ONCE) as workers:
            for line in sys.stdin:
                workers.submit(self._carry_out, operations, json.loads(line))

    def _carry_out(self, operations: Mapping[str, Callable[..., Json]], request: dict[str, Json]) -> None:
        number, name = request.pop("id"), request.pop("do")
        try:
            self._write({"id": number, "answer": operations[name](**request)})
        except Exception as error:  # noqa: BLE001 the check shall see it
            self._write({"id": number, "error": f"{name}: {type(error).__name__}: {error}"})

    def _write(self, said: Mapping[str, Json]) -> None:
        text = json.dumps(said)
        with self._lock:
            self._out.write(f"{text}\n")
            self._out.flush()


def ros_class(name: str, folder: str) -> Any:
    """The class of a type, ``package/Name``; ``folder`` is msg, srv or action."""
    package, _, kind = name.partition("/")
    return getattr(import_module(f"{package}.{folder}"), kind)


def fill(message: Any, values: Mapping[str, Json], make: Callable[[Any, str, Json], Any]) -> Any:
    """A message with fields from JSON; ``make`` makes the value of a field that is a message or a list of them."""
    for name, value in values.items():
        setattr(message, name, make(message, name, value))
    return message


def constants(kind: Any) -> dict[str, int]:
    """The integers that a message type names."""
    return {name: value for name, value in vars(kind).items() if name.isupper() and isinstance(value, int)}


def plain(value: Any, fields: Callable[[Any], Sequence[str] | None]) -> Json:
    """A message as JSON: stamps in nanoseconds, bytes marked as such; ``fields``: None for what is no message."""
    if isinstance(value, bytes):
        return {"bytes": list(value)}
    if hasattr(value, "to_nsec"):
        return value.to_nsec()
    if (names := fields(value)) is not None:
        if sorted(names) == ["nanosec", "sec"]:
            return value.sec * 1_000_000_000 + value.nanosec
        return {name: plain(getattr(value, name), fields) for name in names}
    if isinstance(value, str | int | float):
        return value
    return [plain(each, fields) for each in value]
