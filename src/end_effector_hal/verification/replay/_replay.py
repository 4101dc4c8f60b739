"""Feed recorded inputs to the same controller, which must make the same decisions."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass
from typing import Any

from pydantic_core import to_json

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.plugins import named
from end_effector_hal.runtime.boundary import DECIDED, INPUTS, STATE, RecordedController, feed
from timed_automata import Network

from ._differs import NOTHING, Difference, first_difference
from ._load import ProgramTrace


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
        self,
        trace: ProgramTrace,
        description: Description,
        network: Network,
        before: dict[str, Any] | None,
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

    def _take(self, record: tuple[str, int, object]) -> None:
        if record[0] in DECIDED:
            self._decided.append(record)

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
