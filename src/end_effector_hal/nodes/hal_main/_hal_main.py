"""Node HALMain: the only interface for applications, with its actions and the aggregated state."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace

from end_effector_hal.control import transition
from end_effector_hal.nodes._silence import Silence
from end_effector_hal.nodes.interface import (
    END_EFFECTOR_STATE,
    GRIP,
    GRIP_STATE,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    STATE_HZ,
    position_topics,
    pressure_topics,
)
from end_effector_hal.nodes.report import ERROR, OK, WARN, Health, publish_health, standing
from end_effector_hal.nodes.transport import (
    ChangerPlace,
    CylinderPlace,
    EventMessage,
    MessageHeader,
    NodeTransport,
    PositionMessage,
    PressureMessage,
    StampCheck,
    StatusMessage,
)
from end_effector_hal.sensing import ToolPlace
from end_effector_hal.vocabulary import Command, EndEffectorState, received_alarms
from end_effector_hal.wires import now_us

from ._aggregate import CHANGER, STAND, Aggregate, Margins, Positions
from ._goal_types import goal_types
from ._served_goals import ServedGoals

_ERRORS = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


class HalMainNode:
    """Publishes one EndEffectorState for every status of the program, in order, and one at 10 Hz."""

    def __init__(self, node: NodeTransport) -> None:
        description = node.description()
        cylinders = position_topics(description)
        self._margins = Margins(description)
        self._positions = Positions(
            {CHANGER: ChangerPlace, STAND: ToolPlace, **dict.fromkeys(cylinders, CylinderPlace)}
        )
        self._at_us = now_us()
        self._aggregate = Aggregate(description, self._margins, self._positions, self._at_us)
        self._count = 0
        self._silence = Silence()
        self._known = (0, 0)
        self._stamps = StampCheck("Internal states", node.log)
        self._gone = False
        self._lock = threading.Lock()
        self._closed = False
        self._log, self._unknown_senders = node.log, node.unknown_senders
        self._publish = node.publisher(END_EFFECTOR_STATE)
        self._state = self._aggregate.message(self._at_us, self._at_us, self._silence)
        self._goals = ServedGoals(node, goal_types(description, node.log), lambda: self._state)
        node.subscribe(GRIP_STATE, self._on_status)
        for channel, topic in pressure_topics(description):
            node.subscribe(topic, self._on_pressure(channel))
        for name, topic in cylinders.items():
            node.subscribe(topic, self._on_position(name))
        if description.tool_changer:
            node.subscribe(POSITION_TOOL_CHANGER, self._on_position(CHANGER))
            node.subscribe(POSITION_TOOL_STAND, self._on_position(STAND))
        node.every(STATE_HZ, self._tick)
        publish_health(node, description.name, self._health)
        node.on_close(self._close)
        node.on_close(self._goals.close)

    def _on_status(self, status: StatusMessage) -> None:
        known = (status.since_us, status.count)
        with self._lock:
            if self._closed:
                return  # OFF is the last state
            if not self._stamps.accepts(status.since_us, status.at_us):
                return  # it would show a state that has not come yet
            self._silence.reported(now_us())
            if known == self._known:
                return  # repeated: the periodic state says it
            self._known = known
            self._aggregate.status = status
            self._at_us = status.at_us
            self._count += 1
            self._publish_state(self._at_us, status.events)
        self._goals.on_status(status)

    def _publish_state(self, stamp_us: int | None = None, events: Sequence[EventMessage] = ()) -> None:
        now, before = now_us(), self._gone
        self._gone = self._silence.lasts(now)
        if self._gone != before:
            self._at_us, self._count = now, self._count + 1
        notices = (*self._unknown_senders.alarms(), *self._stamps.notices(now), *self._margins.alarms)
        state = self._aggregate.message(self._at_us, now, self._silence, notices)
        state.header, state.count, state.events = MessageHeader(stamp_us), self._count, events
        earlier, self._state = self._state, state
        self._publish(state)
        if state.state != earlier.state:
            old, new = (EndEffectorState(each.state).name for each in (earlier, state))
            why = next(iter(state.alarms), "") if self._gone else state.reason
            self._log.info("%s", transition(old, new, state.command, why))

    def _tick(self) -> None:
        with self._lock:
            if self._closed:
                return
            before = self._gone
            self._publish_state()
            gone = self._gone
        if gone and not before and self._silence.has_reported:
            self._log.error("the node %s is silent", GRIP)
        self._goals.tick(gone=gone)

    def _on_pressure(self, channel: str) -> Callable[[PressureMessage], None]:
        return lambda message: self._margins.store(channel, message.fluid_pressure)

    def _on_position(self, name: str) -> Callable[[PositionMessage], None]:
        return lambda message: self._positions.store(name, message.position, now_us())

    def _close(self) -> None:
        with self._lock:
            self._closed = True
            self._state = replace(
                self._state,
                events=(),
                count=self._count + 1,
                state=EndEffectorState.OFF,
                state_name=EndEffectorState.OFF.name,
                command=Command.NONE,
                command_name=Command.NONE.name,
                lift_allowed=False,
                secure=False,
                at_us=now_us(),
                header=MessageHeader(),
            )
            self._publish(self._state)

    def _health(self) -> Health:
        state = self._state
        if self._gone and not state.alarms:
            return Health(WARN, f"Starting: {GRIP} did not report yet.")
        bad = self._gone or not state.link_up or state.state in _ERRORS
        warns = standing(received_alarms(state.alarms, state.alarm_ids)) or state.missed
        level = ERROR if bad else WARN if warns else OK
        return Health(
            level,
            " ".join(state.alarms) or "As it should be.",
            {
                "state": EndEffectorState(state.state).name,
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
