"""What a program would write after each possible next event, worked out while it is idle."""

from __future__ import annotations

import logging
from collections.abc import Iterator

from end_effector_hal.control import Foreseen
from end_effector_hal.runtime.boundary import AnyController
from end_effector_hal.runtime.outputs import LineWrite, Outputs
from timed_automata import Event

_log = logging.getLogger("end_effector_hal.runtime")
Key = tuple[str, tuple[tuple[str, int], ...]]


class Foresight:
    """A table from events to writes; it holds in one state of the automata and of the outputs.

    Args:
        controller: says what each event leads to.
        outputs: says what it writes then.
    """

    def __init__(self, controller: AnyController, outputs: Outputs) -> None:
        self._controller, self._outputs = controller, outputs
        self._state: object = None
        self._basis: object = None
        self._pieces: Iterator[Foreseen | None] = iter(())
        self._writes: dict[Key, tuple[int, LineWrite]] = {}

    def go_on(self) -> bool:
        """Work out one more event; return whether there are more."""
        if not self._holds():
            self._state, self._basis = self._controller.discrete_state, self._outputs.basis
            self._pieces, self._writes = self._controller.foresee(), {}
        try:
            for found in self._pieces:
                if found is not None and (write := self._outputs.foresee(found.statuses)):
                    self._writes[_key(found.event)] = found.until, write
                return True
        except Exception:  # noqa: BLE001 it counts when the event comes, if it ever does
            _log.exception("what comes next cannot be worked out ahead")
            self._pieces = iter(())
        return False

    def of(self, event: Event, at: int) -> LineWrite | None:
        """Return what an event at ``at`` µs leads to; None: nothing is written, or it is not worked out."""
        until, write = self._writes.get(_key(event), (at, None))
        return write if at < until and self._holds() else None

    def _holds(self) -> bool:
        return self._controller.discrete_state == self._state and self._outputs.basis == self._basis


def _key(event: Event) -> Key:
    return event.channel, tuple(event.writes.items())
