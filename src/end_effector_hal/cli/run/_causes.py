"""Explains changes by the steps of the automata, with their guards and the sensor readings at that time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import network_of
from end_effector_hal.description import Description
from end_effector_hal.page.view import EventLog
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Value

MOST_WAITING = 1_000
_SHOWN = ("transition", "time-out")


class Causes:
    """Collects the records of the HAL as they arrive, and turns their steps into entries later.

    The HAL calls `take` in its threads, where it only stores the record; `new` is called in any other thread.
    """

    def __init__(self, description: Description) -> None:
        self._log = EventLog(description, network_of(description).document)
        self._readings = Readings(description, carrier_of(description))
        self._waiting: deque[tuple[Any, dict[str, Value | None]]] = deque(maxlen=MOST_WAITING)
        self._told = 0
        self._instant: _Instant | None = None

    def take(self, kind: str, at: int, record: Any) -> None:
        """Store one record with its time ``at`` in µs."""
        if kind == "frame":
            self._readings.take(record.frame)
        elif kind == "step":
            now = self._readings
            self._waiting.append((record, {name: now.get(name, at) for name in now.carried}))

    def new(self) -> Iterator[dict[str, Any]]:
        """Yield the visible steps since the last call: ``at`` (µs), ``text``, ``kind``, and the details.

        ``cause``: the event that began the instant of the step; None: time had passed. ``edges``: the edges from that
        event to the step, and those of the step. Readings are in kPa gauge; bits are unchanged.
        """
        while self._waiting:
            step, readings = self._waiting.popleft()
            kpa = {
                name: value if value is None or isinstance(value, bool) else value / 1000
                for name, value in readings.items()
            }
            self._log.take("step", step, kpa)
        for entry in self._log.since(self._told):
            yield from self._with_cause(entry)
        self._told = self._log.newest

    def _with_cause(self, entry: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """Yield the entry with the event that began its instant, and the steps in between."""
        at, detail = entry["at"], entry["detail"]
        if detail is None:
            return
        instant = self._instant
        if instant is None or instant.at != at or detail["received"] is not None:
            instant = self._instant = _Instant(at, detail["received"])
        if entry["kind"] not in _SHOWN:
            instant.through += detail["edges"]
            return
        through, instant.through = instant.through, []
        yield {
            "at": at,
            "text": entry["text"],
            "kind": entry["kind"],
            "cause": instant.event,
            "edges": [*through, *detail["edges"]],
            "changes": detail["changes"],
            "late_ms": detail["late_ms"],
            "readings": detail["readings"],
        }


@dataclass
class _Instant:
    """The event that began an instant, and the edges in it since the last visible step."""

    at: int
    event: str | None
    through: list[dict[str, Any]] = field(default_factory=list)
