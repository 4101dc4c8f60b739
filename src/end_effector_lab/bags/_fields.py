"""Converts the messages of a bag to those of the nodes, and places their stamps on one time axis.

Every field is checked, and an older version lacks some; a machine may have been restarted in the middle of a bag.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from math import isfinite
from typing import Any, TypeVar

from end_effector_hal.nodes.data_logger import events_of
from end_effector_hal.nodes.transport import AMBIENT_PA, EventMessage, StateMessage
from end_effector_hal.recording import is_part_name
from end_effector_hal.vocabulary import ActuatorState, Command, EndEffectorState

Value = TypeVar("Value")
OPTIONAL = ("since_us", "count", "tool", "tool_changer", "alarms", "alarm_ids", "events")
"""Fields of a state that are used, but that an older version may lack."""
_KINDS: dict[Any, type] = {"int": int, "str": str}


def state_of(content: Any) -> StateMessage:
    """Return the state; fields that the bag lacks are empty. Raises ValueError if it is not a state."""
    used: dict[str, Any] = {
        "at_us": _one(content, "at_us", int),
        "state": EndEffectorState(_one(content, "state", int)),
        "command": Command(_one(content, "command", int)),
        "actuator_names": _list(content, "actuator_names", str),
        "actuator_kinds": _list(content, "actuator_kinds", str),
        "actuators": [ActuatorState(each) for each in _list(content, "actuators", int)],
        "since_us": _one(content, "since_us", int, 0),
        "count": _one(content, "count", int, 0),
        "tool": _one(content, "tool", str, ""),
        "tool_changer": _one(content, "tool_changer", int, 0),
        "part": _one(content, "part", str),
        "alarms": _list(content, "alarms", str, []),
        "alarm_ids": _list(content, "alarm_ids", str, []),
        "events": [_event(each) for each in getattr(content, "events", ())],
    }
    if len(used["actuator_names"]) != len(used["actuators"]):
        raise ValueError("its lists are not of the same length")
    if not is_part_name(used["part"]):
        raise ValueError("its part is not a name")
    unused: dict[str, Any] = {each.name: None for each in fields(StateMessage) if each.name not in used}
    message = StateMessage(**used, **unused)
    events_of(message)
    return message


def _event(content: Any) -> EventMessage:
    return EventMessage(
        **{each.name: _one(content, each.name, _KINDS[each.type]) for each in fields(EventMessage)}
    )


def pressure_of(content: Any) -> int | None:
    """Return the gauge pressure, Pa; None: not known. Raises ValueError if it is not a pressure."""
    absolute = _one(content, "fluid_pressure", float)
    return round(absolute) - AMBIENT_PA if isfinite(absolute) else None


def command_of(content: Any) -> tuple[Command, str]:
    """Return the command, and the part that a grip is for; raises ValueError if it is not a command."""
    return Command(_one(content, "command", int)), _one(content, "part", str)


def lacking(content: Any) -> tuple[str, ...]:
    """Return the fields that this version uses and that the state lacks."""
    return tuple(each for each in OPTIONAL if not hasattr(content, each))


def _one(content: Any, name: str, kind: Callable[..., Value], default: Value | None = None) -> Value:
    value: Value | None = getattr(content, name, default)
    if value is None:
        raise ValueError(f"it has no field {name}")
    if type(value) is not kind:
        raise ValueError(f"its field {name} is of another type")
    return value


def _list(content: Any, name: str, kind: type[Value], default: list[Value] | None = None) -> list[Value]:
    values = getattr(content, name, default)
    if values is None:
        raise ValueError(f"it has no field {name}")
    found = values.tolist() if hasattr(values, "tolist") else values  # an array of numpy
    if not isinstance(found, list) or not all(type(each) is kind for each in found):
        raise ValueError(f"its field {name} is of another type")
    return found


BACK_US = 2_000_000
"""A stamp that is further back than this belongs to a restarted clock, µs."""
AHEAD_US = 3_600_000_000
"""A stamp that is further ahead of the bag's own time than this is of another clock, or invalid, µs."""


class LineOfTime:
    """Places stamps on one time axis. When the clock jumps, the recording times of the messages give the elapsed time.

    Attributes:
        jumps: number of jumps of the clock.
    """

    def __init__(self) -> None:
        self.jumps = 0
        self._shift = 0
        self._last: dict[str, tuple[int, int | None]] = {}

    def place(self, stream: str, at: int, log_us: int, *, fresh: bool) -> int:
        """Return the place of a stamp, µs.

        Args:
            stream: name of the stream; the stamps of one stream are in order.
            at: time on the monotonic clock of the machine that made the stamp, µs.
            log_us: time at which the message was recorded, µs.
            fresh: whether the first stamp of the stream was made when its message was published.
        """
        placed = at + self._shift
        if stream not in self._last:
            self._last[stream] = (placed, log_us if fresh else None)
            return placed
        before, since = self._last[stream]
        if placed == before:
            return placed  # a state that is repeated: it was made at the first of them
        passed = 0 if since is None else max(0, log_us - since)
        behind = placed < before - BACK_US
        if behind or (since is not None and placed > before + passed + AHEAD_US):
            self._shift += before + passed - placed
            self.jumps += 1
            placed = before + passed
        self._last[stream] = (placed, log_us)
        return placed
