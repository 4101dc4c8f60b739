"""Build one state of the end-effector from the status of the tool and from what its sensors read."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from math import nan

from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.nodes._places import ChangerPlace, changer_place
from end_effector_hal.nodes.interface import actuator_joints
from end_effector_hal.nodes.transport import EventMessage, MessageHeader, StateMessage, StepMessage
from end_effector_hal.sensing import ToolPlace, tool_place
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Alarm, distinct


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
