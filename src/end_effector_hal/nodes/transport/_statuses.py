"""Convert the status of a program to its message, and back."""

from __future__ import annotations

from collections.abc import Sequence

from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.vocabulary import (
    Cause,
    ChangerState,
    Command,
    EndEffectorState,
    Evidence,
    received_alarms,
)

from ._messages import EventMessage, MessageHeader, StatusMessage, StepMessage


def status_to_message(
    status: Status, since_us: int, count: int, actuators: Sequence[str] = ()
) -> StatusMessage:
    """Return the message for a status.

    Args:
        status: the status, with its events.
        since_us: the start of the program, µs.
        count: the number of this status.
        actuators: names of the actuators, in sequence order.
    """
    return StatusMessage(
        header=MessageHeader(status.at),
        since_us=since_us,
        count=count,
        at_us=status.at,
        state=status.ee,
        command=status.command,
        actuators=status.actuators,
        outputs=status.outputs,
        evidence=status.evidence,
        step=status.step,
        attempt=status.attempt,
        attempts_allowed=status.attempts_allowed,
        deadline_us=-1 if status.deadline is None else status.deadline,
        cause=status.cause,
        cause_at=status.cause_at,
        reason=status.reason,
        held=status.held,
        lift_allowed=status.lift_allowed,
        secure=status.secure,
        maintenance=status.maintenance,
        tool_changer=status.changer,
        unlock_output=status.unlock_output,
        changer_reason=status.changer_reason,
        link_up=status.link_up,
        stale=status.stale,
        missed=status.missed,
        worst_late_us=status.worst_late_us,
        alarms=status.alarm_texts,
        alarm_ids=[alarm.name for alarm in status.alarms],
        steps=[StepMessage(step.name, step.attempts, step.seconds, step.confirmed) for step in status.steps],
        events=[_event(each, actuators) for each in status.events],
    )


def status_from_message(message: StatusMessage) -> Status:
    """Return the status of a message, with all that decides how a command has ended."""
    return Status(
        at=message.at_us,
        ee=EndEffectorState(message.state),
        command=Command(message.command),
        actuators=tuple(message.actuators),
        outputs=tuple(message.outputs),
        evidence=tuple(map(Evidence, message.evidence)),
        cause=Cause(message.cause),
        reason=message.reason,
        changer=ChangerState(message.tool_changer),
        changer_reason=message.changer_reason,
        alarms=received_alarms(message.alarms, message.alarm_ids),
        begun=message.since_us,
        count=message.count,
    )


def _event(event: ToolEvent, actuators: Sequence[str]) -> EventMessage:
    name = actuators[event.actuator] if event.actuator >= 0 else ""
    states = event.old, event.new
    return EventMessage(event.at, event.kind, name, event.attempt, *states, event.cause, event.command)
