"""What a unit says of itself, as a message."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from end_effector_msgs.msg import StepReport, UnitStatus

from end_effector_hal.control import Status
from end_effector_hal.control import StepReport as Report

from ._node import stamp


def status_to_message(status: Status, since_us: int, count: int) -> Any:
    """A UnitStatus; ``since_us`` is the start of the unit, ``count`` the number of this status."""
    return UnitStatus(
        header=_header(status.at),
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
        link_up=status.link_up,
        stale=status.stale,
        missed=status.missed,
        worst_late_us=status.worst_late_us,
        alarms=status.alarms,
        steps=steps_to_messages(status.steps),
    )


def steps_to_messages(steps: Iterable[Report]) -> list[Any]:
    """StepReports, in order."""
    return [
        StepReport(actuator=step.name, attempts=step.attempts, seconds=step.seconds, confirmed=step.confirmed)
        for step in steps
    ]


def _header(at_us: int) -> Any:
    from std_msgs.msg import Header

    return Header(stamp=stamp(at_us))
