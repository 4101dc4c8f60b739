"""Two programs, one tool: its status, and what a reset of it has come to."""

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
    """The status of the whole tool at ``at`` µs.

    A program that has gone says nothing any more: the state is OFF, its evidence UNKNOWN, nothing may be lifted. Its
    outputs and ``held`` stay as they were last known: the line arbiter holds what was held.

    Args:
        grip, change: the newest statuses of both programs.
        at: the time of the one that has changed; the other one may be a little ahead.
        gone: the programs that are not there any more.
        notices: alarms of the tool beside those of its programs.
        events: of the program that has changed.
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
    """What a reset has come to, from the answers of all that latch a fault."""
    stays = [answer for answer in answers if not answer.accepted]
    if not stays:
        return Answer(True, NOTHING_LATCHED)
    reason = " ".join(dict.fromkeys(answer.reason for answer in stays))
    return Answer(False, reason, decided=all(answer.decided for answer in stays))
