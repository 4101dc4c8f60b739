"""Feed recorded inputs to the same controller, which must make the same decisions.

`first_difference` finds where two records differ.
"""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass, replace
from typing import Any

from pydantic_core import to_json

from end_effector_hal.control import word_of
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.plugins import named
from end_effector_hal.runtime.boundary import DECIDED, INPUTS, STATE, RecordedController, entry_of, feed
from end_effector_hal.verification.replay._load import ProgramTrace
from timed_automata import Network

NOTHING = "nothing"
_UNTOLD = frozenset({"where"})
"""Fields that are not compared: the place of an edge in its file is not part of a decision."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first decision that differs.

    Attributes:
        at: time of the record, µs.
        what: kind of the record, and the field in it.
        recorded, replayed: the values.
        names: the words for the two values, if they are numbers of Table II or similar.
    """

    at: int
    what: str
    recorded: object
    replayed: object
    names: tuple[str | None, str | None] = (None, None)

    def __str__(self) -> str:
        old, new = (
            f"{_short(value)} ({name})" if name else _short(value)
            for value, name in zip((self.recorded, self.replayed), self.names, strict=True)
        )
        return f"{self.what}: recorded {old}, replayed {new}"

    def named(self, description: Description) -> Difference:
        """Return a copy with the words of a tool for its numbers."""
        variable = self.what.rpartition(".")[2].replace("actuators[", "actuator[")
        old, new = (
            word_of(description, variable, value) if type(value) is int else None
            for value in (self.recorded, self.replayed)
        )
        return replace(self, names=(old, new))


def first_difference(kind: str, recorded: Any, replayed: Any) -> Difference | None:
    """Return the first field that differs; None: none does."""
    found = _differs(recorded, replayed, kind)
    if found is None:
        return None
    what, old, new = found
    return Difference(recorded["at"], what, old, new)


def _differs(old: Any, new: Any, what: str) -> tuple[str, Any, Any] | None:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted((old.keys() | new.keys()) - _UNTOLD):
            found = _differs(old.get(key, NOTHING), new.get(key, NOTHING), f"{what}.{key}")
            if found:
                return found
        return None
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return next((found for i, (a, b) in pairs if (found := _differs(a, b, f"{what}[{i}]"))), None)
    return None if old == new and isinstance(old, bool) == isinstance(new, bool) else (what, old, new)


def _short(value: object) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= 120 else text[:117] + "…"


@dataclass(frozen=True, slots=True)
class Replay:
    """The result of a replay.

    Attributes:
        inputs: number of inputs that were fed.
        compared: number of recorded decisions that were compared.
        difference: the first one that differs; None: none does.
        end: the state of the controller after the last input, as JSON; None: unknown.
    """

    inputs: int
    compared: int
    difference: Difference | None
    end: dict[str, Any] | None = None


def replay(
    trace: ProgramTrace, description: Description, network: Network, before: dict[str, Any] | None = None
) -> Replay:
    """Feed the inputs of a trace to a controller until a decision differs from the recorded one.

    Args:
        trace: one segment.
        description: the tool to replay with.
        network: its automata with its constants.
        before: the ``end`` of the previous segment, if nothing is missing between the two; None: unknown.

    Raises:
        UsageError: a record cannot be read.
    """
    return _Replay(trace, description, network, before).run()


class _Replay:
    def __init__(
        self, trace: ProgramTrace, description: Description, network: Network, before: dict[str, Any] | None
    ) -> None:
        self._trace, self._description, self._network = trace, description, network
        self._before = before
        self._controller: RecordedController | None = None
        self._decided: deque[tuple[str, int, object]] = deque()
        self._inputs = self._compared = 0

    def run(self) -> Replay:
        difference: Difference | None = None
        for number, record in enumerate(self._trace.file.records):
            if record.kind == STATE:
                difference = self._resume(number)
            elif record.kind in INPUTS:
                difference = self._all_told() or self._feed(record.kind, self._trace.typed(number))
            elif record.kind in DECIDED:
                difference = self._compare(record.kind, self._trace.content(number))
            if difference:
                break
        else:
            # the records after the last input may have been lost with the program
            difference = self._all_told() if self._trace.file.complete else None
        end = self._state() if difference is None and self._trace.file.complete else None
        return Replay(self._inputs, self._compared, difference, end)

    def _resume(self, number: int) -> Difference | None:
        """Resume from the recorded state, which must be valid and equal the end of the previous segment."""
        state, recorded = self._trace.typed(number), self._trace.content(number)
        if self._controller is not None or self._inputs:
            return Difference(state.at, STATE, "a state in the middle of a segment", NOTHING)
        self._controller = self._new_controller()
        try:
            self._controller.resume(state)
        except ReportedError as error:
            return Difference(state.at, STATE, "a state", f"refused: {error}")
        self._compared += 1
        expected = self._state() or {}
        found = first_difference(STATE, recorded, expected)
        return found or (first_difference(STATE, recorded, self._before) if self._before else None)

    def _state(self) -> dict[str, Any] | None:
        snapshot = self._controller.snapshot() if self._controller is not None else None
        return None if snapshot is None else _as_json(snapshot)

    def _new_controller(self) -> RecordedController:
        return RecordedController(self._description, self._network, self._take)

    def _feed(self, kind: str, record: Any) -> Difference | None:
        self._inputs += 1
        try:
            if kind == "start":
                self._controller = self._new_controller()
            if self._controller is None:
                return Difference(record.at, kind, f"{kind} before the start", NOTHING)
            feed(self._controller, kind, record)
        except ReportedError as error:
            return Difference(record.at, kind, "taken", f"refused: {error}")
        except Exception as error:  # noqa: BLE001 a recorded state may fit its form, and make no sense
            return Difference(record.at, kind, "taken", f"impossible in this state: {named(error)}")
        return None

    def _take(self, record: object) -> None:
        if (entry := entry_of(record))[0] in DECIDED:
            self._decided.append(entry)

    def _compare(self, kind: str, recorded: dict[str, Any]) -> Difference | None:
        if not self._decided:
            return Difference(recorded["at"], kind, _brief(recorded), NOTHING)
        replayed_kind, _, content = self._decided.popleft()
        replayed = _as_json(content)
        if replayed_kind != kind:
            at = recorded["at"]
            return Difference(
                at, "decision", f"{kind} {_brief(recorded)}", f"{replayed_kind} {_brief(replayed)}"
            )
        self._compared += 1
        return first_difference(kind, recorded, replayed)

    def _all_told(self) -> Difference | None:
        if not self._decided:
            return None
        kind, at, content = self._decided[0]
        return Difference(at, kind, NOTHING, _brief(_as_json(content)))


def _as_json(content: object) -> dict[str, Any]:
    """Return the content as it would be recorded."""
    found: dict[str, Any] = json.loads(to_json(content, fallback=dict))
    return found


def _brief(content: dict[str, Any]) -> str:
    """Return the fields that distinguish a record from others."""
    if "edges" in content:
        moves = [f"{edge['process']} {edge['source']} → {edge['target']}" for edge in content["edges"]]
        return " with ".join(moves)
    return ", ".join(
        f"{key}={content[key]!r}" for key in ("channel", "writes", "ee", "accepted", "at") if key in content
    )
