"""Node HALMain: the only interface for applications, with its actions and the aggregated state."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace

from end_effector_hal.control import Status, event_lines
from end_effector_hal.nodes.interface import END_EFFECTOR_STATE, HAL_MAIN, STATE_HZ
from end_effector_hal.nodes.report import Health, level_of, publish_health, silence
from end_effector_hal.nodes.transport import NodeTransport
from end_effector_hal.vocabulary import Command, EndEffectorState, alarm_changes
from end_effector_hal.wires import now_us

from ._aggregate import Aggregate
from ._goal_types import goal_types
from ._served_goals import ServedGoals


class HalMainNode:
    """Publishes one EndEffectorState for every status of the tool, in order, and one at 10 Hz."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        self._description = description = self._tool.description
        self._aggregate = Aggregate(description, now_us())
        self._status, self._count = self._tool.status, 0
        self._readings = self._tool.follow_readings()
        self._lock = threading.Lock()
        self._closed = False
        self._publish = node.publisher(END_EFFECTOR_STATE)
        self._state = self._aggregate.message(self._status, {}, now_us(), count=0, stamp_us=None)
        self._goals = ServedGoals(node, goal_types(description, node.log), self._tool, lambda: self._state)
        self._tool.subscribe(self._on_status, name=HAL_MAIN)
        node.every(STATE_HZ, self._tick)
        publish_health(node, description.name, self._health)
        node.on_close(self._close)
        node.on_close(self._goals.close)

    def _on_status(self, status: Status) -> None:
        with self._lock:
            if self._closed:
                return  # OFF is the last state
            before, self._count = self._status, self._count + 1
            self._publish_state(status, status.at)
            # the periodic states repeat it without its events
            self._status = replace(status, events=())
        self._goals.on_status(status)
        for line in event_lines(self._description, status):
            self._log.info("%s", line)
        for alarm, change in alarm_changes(before.alarms, status.alarms):
            if change != "ended":
                self._log.log(logging.INFO if alarm.over else logging.WARNING, "%s", alarm)

    def _publish_state(self, status: Status, stamp_us: int | None = None) -> None:
        self._state = self._aggregate.message(
            status, self._readings().values, now_us(), count=self._count, stamp_us=stamp_us
        )
        self._publish(self._state)

    def _tick(self) -> None:
        with self._lock:
            if self._closed:
                return
            self._publish_state(self._status)
        self._goals.tick(gone=not self._tool.alive)

    def _close(self) -> None:
        with self._lock:
            self._closed = True
            self._count += 1
            self._publish_state(
                replace(
                    self._status,
                    at=now_us(),
                    ee=EndEffectorState.OFF,
                    command=Command.NONE,
                    lift_allowed=False,
                    secure=False,
                )
            )

    def _health(self) -> Health:
        if silent := silence(self._tool):
            return silent
        state, status = self._state, self._status
        return Health(
            level_of(status),
            " ".join(state.alarms) or "As it should be.",
            {
                "state": status.ee.name,
                "reason": status.reason,
                "held": status.held,
                "secure": status.secure,
                "lift allowed": status.lift_allowed,
                "position of tool_changer": state.tool_position_name,
                "position of tool_stand": state.tool_stand_name,
            },
        )
