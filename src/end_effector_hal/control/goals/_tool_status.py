"""The joint status of a tool's two programs, and the joint answer to a reset."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from end_effector_hal.vocabulary import Alarm, ChangerState, Command, EndEffectorState, Evidence, distinct

from .._events import ToolEvent
from .._status import Answer, Status

NOTHING_LATCHED = "No fault is latched any more. GRIP_ERROR and RELEASE_ERROR, if any, stay until a Drop."


def tool_status(
    grip: Status,
    change: Status,
    at: int,
    *,
    gone: Collection[str] = (),
    notices: Iterable[Alarm] = (),
    events: tuple[ToolEvent, ...] = (),
) -> Status:
    """Return the status of the whole tool at ``at`` µs.

    For a program that has gone, the state is OFF, its evidence UNKNOWN, and lifting is not allowed. Its outputs and
    ``held`` keep their last known values: the line arbiter goes on holding the part.

    Args:
        grip, change: the newest statuses of both programs.
        at: time of the status that has changed; the other one may be a little ahead.
        gone: the programs that no longer run.
        notices: alarms of the tool that do not come from its programs.
        events: events of the program that has changed.
    """
    if "grip" in gone:
        grip = replace(
            grip, ee=EndEffectorState.OFF, command=Command.NONE, evidence=(Evidence.UNKNOWN,) * len(grip.evidence),
            step=-1, deadline=None, lift_allowed=False, secure=False, maintenance=False, link_up=False,
        )  # fmt: skip
    if "tool_change" in gone:
        change = replace(change, changer=ChangerState.UNKNOWN, command=Command.NONE)
    return replace(
        grip,
        at=at,
        # one command runs at a time: gripping and the tool changer exclude each other (IL-01, IL-05)
        command=grip.command if grip.command != Command.NONE else change.command,
        changer=change.changer,
        changer_fault=change.changer_fault,
        armed=change.armed,
        # its newest status says why it is UNKNOWN; that of the gripping may be a little older
        stale=tuple(dict.fromkeys((*grip.stale, *change.stale)))
        if change.changer is ChangerState.UNKNOWN
        else grip.stale,
        unlock_output=change.unlock_output,
        missed=grip.missed + change.missed,
        worst_late_us=max(grip.worst_late_us, change.worst_late_us),
        events=events,
        alarms=distinct((*notices, *grip.alarms, *change.alarms)),
    )


def reset_answer(answers: Iterable[Answer]) -> Answer:
    """Return the joint answer to a reset from the answers of all programs that latch faults."""
    stays = [answer for answer in answers if not answer.accepted]
    if not stays:
        return Answer(True, NOTHING_LATCHED)
    reason = " ".join(dict.fromkeys(answer.reason for answer in stays))
    return Answer(False, reason, decided=all(answer.decided for answer in stays))
