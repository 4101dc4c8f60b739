"""Node HALMain: the only interface for applications, with its actions and the aggregated state."""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping
from dataclasses import replace
from enum import IntEnum
from math import nan

from end_effector_hal.control import Status, ToolEvent, event_lines
from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.sensing import ToolPlace, tool_place
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Alarm, Command, EndEffectorState, alarm_changes, distinct
from end_effector_hal.wires import now_us

from ._goal_types import goal_types
from ._position import ChangerPlace, changer_place
from ._served_goals import ServedGoals
from .interface import END_EFFECTOR_STATE, HAL_MAIN, STATE_HZ, actuator_joints
from .report import Health, level_of, publish_health, silence
from .transport import EventMessage, MessageHeader, NodeTransport, StateMessage, StepMessage


class Aggregate:
    """Makes the messages of EndEffectorState.

    Args:
        description: the tool.
        since_us: the start of HALMain, µs.
    """

    def __init__(self, description: Description, since_us: int) -> None:
        self._description, self._since_us = description, since_us
        self._kinds = {actuator.kind: kind_of(actuator) for _, actuator in description.ordered}
        joints = {joint.actuator: joint for joint in actuator_joints(description)}
        self._joints = [joints.get(name) for name in description.sequence]

    def message(
        self, status: Status, values: Mapping[str, Value], now_us: int, *, count: int, stamp_us: int | None
    ) -> StateMessage:
        """Return the state.

        Args:
            status: the latest status, with its events.
            values: what the sensors read, by channel.
            now_us: the time now, µs.
            count: the number of this state.
            stamp_us: the time of its content, µs; None: now.
        """
        description, sequence = self._description, self._description.sequence
        actuators, changer = description.for_part(status.part).ordered, description.tool_changer
        position = changer_place(changer, values) if changer else ChangerPlace.UNKNOWN
        stand = tool_place(changer, values) if changer else ToolPlace.UNKNOWN
        margins = [self._margin(actuator, values) for _, actuator in actuators]
        alarms = distinct((*self._kind_alarms, *status.alarms))  # with those of the margins
        return StateMessage(
            header=MessageHeader(stamp_us),
            since_us=self._since_us,
            count=count,
            at_us=status.at,
            tool=description.name,
            state=status.ee,
            state_name=status.ee.name,
            command=status.command,
            command_name=status.command.name,
            actuator_names=sequence,
            actuator_kinds=[actuator.kind for _, actuator in actuators],
            actuators=status.actuators,
            actuator_states=[
                _name(kind_of(actuator).states, state)
                for (_, actuator), state in zip(actuators, status.actuators, strict=True)
            ],
            outputs=status.outputs,
            evidence=status.evidence,
            evidence_names=[each.name for each in status.evidence],
            margins=margins,
            margin_units=["Pa"] * len(sequence),
            positions=[joint.position(status.evidence) if joint else nan for joint in self._joints],
            actuator="" if status.step < 0 else sequence[status.step],
            attempt=status.attempt,
            attempts_allowed=status.attempts_allowed,
            time_left_s=nan if status.deadline is None else max(0, status.deadline - now_us) / 1e6,
            steps=[
                StepMessage(step.name, step.attempts, step.seconds, step.confirmed) for step in status.steps
            ],
            cause=status.cause,
            cause_name=status.cause.name,
            cause_actuator=sequence[status.cause_at] if status.cause_at >= 0 else "",
            reason=status.reason,
            held=status.held,
            part=status.part,
            lift_allowed=status.lift_allowed,
            secure=status.secure,
            maintenance=status.maintenance,
            tool_changer=status.changer,
            tool_changer_name=status.changer.name,
            unlock_output=status.unlock_output,
            tool_position=position,
            tool_position_name=position.name,
            tool_stand=stand,
            tool_stand_name=stand.name,
            link_up=status.link_up,
            stale=status.stale,
            missed=status.missed,
            worst_late_us=status.worst_late_us,
            alarms=[*map(str, alarms)],
            alarm_ids=[alarm.name for alarm in alarms],
            events=[_event(each, sequence) for each in status.events],
        )  # fmt: skip

    def _margin(self, actuator: Actuator, values: Mapping[str, Value]) -> float:
        supply = self._description.supply
        supply_pa = supply.pressure_pa(_gauge(values.get(supply.channel)))
        return kind_of(actuator).margin_pa(actuator, _gauge(values.get(actuator.channel)), supply_pa)

    @property
    def _kind_alarms(self) -> list[Alarm]:
        """An alarm for each plug-in kind whose margins are unknown because it has failed."""
        found = ((name, fault_of(kind)) for name, kind in self._kinds.items())
        return [Alarm("kind.failed", name, {"why": fault}) for name, fault in found if fault]


def _gauge(value: Value) -> float:
    return nan if value is None or isinstance(value, bool) else float(value)


def _event(event: ToolEvent, actuators: tuple[str, ...]) -> EventMessage:
    name = actuators[event.actuator] if event.actuator >= 0 else ""
    states = event.old, event.new
    return EventMessage(event.at, event.kind, name, event.attempt, *states, event.cause, event.command)


def _name(words: type[IntEnum], value: int) -> str:
    """Return the name of a state of a kind; an integer that is none of its states is returned as text."""
    try:
        return words(value).name
    except ValueError:
        return str(value)


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
