"""Node HALMain: the only interface of applications; four actions, and the aggregated state."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

from end_effector_msgs.msg import Command, State

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState as TableState
from end_effector_hal.wires import now_us

from ._aggregate import CHANGER, STAND, Aggregate
from ._diagnostics import ERROR, OK, WARN, Health, diagnose
from ._margins import Margins
from ._node import Node, stamp
from ._positions import Positions
from ._presence import Presence
from ._served_goals import ServedGoals
from ._stamped import Stamped
from ._status_lines import transition
from ._table import (
    END_EFFECTOR_STATE,
    GRIP,
    GRIP_STATE,
    HAL_MAIN,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    STATE_HZ,
    TOOL_CHANGE,
    TOOL_CHANGE_STATE,
    position_topics,
    pressure_topics,
)

_ERRORS = (State.GRIP_ERROR, State.RELEASE_ERROR)


class HalMainNode:
    """Every status that a unit sends becomes one EndEffectorState, in order; besides that one at 10 Hz."""

    def __init__(self, node: Node, description: Description) -> None:
        self._margins = Margins(description)
        self._positions = Positions()
        self._aggregate = Aggregate(description, self._margins, self._positions)
        self._presence = Presence((GRIP, TOOL_CHANGE) if description.tool_changer else (GRIP,))
        self._known: dict[str, tuple[int, int]] = {}
        self._stamped = Stamped("Internal states", node.log)
        self._gone: tuple[str, ...] = ()
        self._lock = threading.Lock()
        self._log, self._strangers = node.log, node.strangers
        self._publish = node.publisher(END_EFFECTOR_STATE)
        self._at_us = now_us()
        self._state = self._aggregate.message(self._at_us, self._at_us, self._presence)
        self._goals = ServedGoals(lambda: self._state, node.log)
        node.subscribe(GRIP_STATE, self._on_status(GRIP))
        node.subscribe(TOOL_CHANGE_STATE, self._on_status(TOOL_CHANGE))
        for channel, topic in pressure_topics(description):
            node.subscribe(topic, self._on_pressure(channel))
        for name, topic in position_topics(description).items():
            node.subscribe(topic, self._on_position(name))
        if description.tool_changer:
            node.subscribe(POSITION_TOOL_CHANGER, self._on_position(CHANGER))
            node.subscribe(POSITION_TOOL_STAND, self._on_position(STAND))
        node.every(STATE_HZ, self._tick)
        diagnose(node, description.name, self._health)
        node.on_close(self._close)
        node.on_close(self._goals.close)

    def _on_status(self, name: str) -> Callable[[Any], None]:
        return lambda status: self._take(name, status)

    def _take(self, name: str, status: Any) -> None:
        known = (status.since_us, status.count)
        with self._lock:
            if not self._stamped.counts(status.since_us, status.at_us):
                return  # it would show a state that has not come yet
            self._presence.heard(name, now_us())
            if self._known.get(name) == known:
                return  # repeated: the periodic state says it
            self._known[name] = known
            if name == GRIP:
                self._aggregate.grip = status
            else:
                self._aggregate.tool_change = status
            # the exact time of the unit that changed: the other one, over its own connection, may be a little ahead
            self._at_us = status.at_us
            self._tell(self._at_us)
        self._goals.on_status(name, status)

    def _tell(self, stamp_us: int | None = None) -> None:
        now, before = now_us(), self._gone
        self._gone = self._presence.gone(now)
        if self._gone != before:
            self._at_us = now
        notices = (*self._strangers.alarms(), *self._stamped.notices(now))
        state = self._aggregate.message(self._at_us, now, self._presence, notices)
        state.header.stamp = stamp(stamp_us)
        earlier, self._state = self._state, state
        self._publish(state)
        if state.state != earlier.state:
            old, new = (TableState(each.state).name for each in (earlier, state))
            why = next(iter(state.alarms), "") if GRIP in self._gone else state.reason
            self._log.info("%s", transition(old, new, state.command, why))

    def _tick(self) -> None:
        with self._lock:
            before = self._gone
            self._tell()
        for name in self._gone:
            if name not in before and self._presence.known(name):
                self._log.error("the node %s is silent", name)
        self._goals.tick(self._gone)

    def _on_pressure(self, channel: str) -> Callable[[Any], None]:
        return lambda message: self._margins.take(channel, message.fluid_pressure)

    def _on_position(self, name: str) -> Callable[[Any], None]:
        return lambda message: self._positions.take(name, message, now_us())

    def _close(self) -> None:
        with self._lock:
            self._state.state, self._state.command = State.OFF, Command.NONE
            self._state.lift_allowed, self._state.secure, self._state.at_us = False, False, now_us()
            self._state.header.stamp = stamp()
            self._publish(self._state)

    def _health(self) -> Health:
        state = self._state
        bad = self._gone or not state.link_up or state.state in _ERRORS
        level = ERROR if bad else WARN if state.alarms or state.missed else OK
        return Health(
            level,
            " ".join(state.alarms) or "As it should be.",
            {
                "state": TableState(state.state).name,
                "reason": state.reason,
                "held": state.held,
                "secure": state.secure,
                "lift allowed": state.lift_allowed,
                **{
                    f"position of {name}": position
                    for name, position in self._positions.names(now_us()).items()
                },
            },
        )


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(HAL_MAIN, argv)
    HalMainNode(node, node.description())
    return node.spin()
