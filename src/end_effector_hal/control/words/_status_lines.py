"""A line for each transition, time-out and refusal, with its cause: for the log of a node and for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.control._status import Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import Cause, ChangerState, Command, EndEffectorState, Evidence, display_name

from ._changer_reasons import explain_changer

_QUIET = (EndEffectorState.GRIPPING, EndEffectorState.GRIPPED)
"""In these states the reason of an earlier end says nothing."""
_OF_THE_CHANGER = (Command.LOCK, Command.UNLOCK)
"""Executed by the tool changer's program; a transition of the other one does not come from it."""


def transition(old: str, new: str, command: int, reason: str) -> str:
    """``STAND_BY -> GRIPPING (GRIP)``, with the reason if there is one."""
    doing = f" ({Command(command).name})" if command != Command.NONE else ""
    return f"{old} -> {new}{doing}{f': {reason}' if reason else ''}"


def refused(what: str, why: str) -> str:
    """``refused: drop. Nothing is held …``"""
    return f"refused: {what}. {why}"


def unanswered(what: str, why: str) -> str:
    """``unreachable: drop. The line arbiter is lost: …``"""
    return f"unreachable: {what}. {why}"


class StatusLines:
    """Compares each status with the one before.

    Args:
        description: the tool.
        program: ``grip`` or ``tool_change``, whose statuses they are; default: they are of the whole tool.
    """

    def __init__(self, description: Description, program: str = "") -> None:
        self._description, self._parts = description, description.ordered
        self._follow = {"grip": (self._gripping,), "tool_change": (self._changing,)}.get(
            program, (self._gripping, self._changing)
        )
        self._last: Status | None = None
        self._timed_out: set[tuple[int, int]] = set()
        self._released: int | None = None

    def of(self, status: Status) -> list[str]:
        """The lines of a status, in the order of what happened."""
        last, self._last = self._last, status
        return [line for follow in self._follow for line in follow(last, status)]

    def _changing(self, last: Status | None, now: Status) -> Iterator[str]:
        old, new = ChangerState(last.changer if last else 0), ChangerState(now.changer)
        if old is not new:
            command = now.command if now.command in _OF_THE_CHANGER else Command.NONE
            yield f"tool changer: {transition(old.name, new.name, command, self._why(new, now))}"

    def _why(self, changer: ChangerState, now: Status) -> str:
        if changer is ChangerState.FAULT:
            return explain_changer(self._description, now.changer_fault)
        stanza = self._description.tool_changer
        if changer is not ChangerState.UNKNOWN or stanza is None:
            return ""
        stale = [bit for bit in (stanza.locked_bit, stanza.unlocked_bit) if bit in now.stale]
        return f"no valid reading of {', '.join(stale)}" if stale else ""

    def _gripping(self, last: Status | None, now: Status) -> Iterator[str]:
        old, new = EndEffectorState(last.ee if last else 0), EndEffectorState(now.ee)
        if last is not None:
            yield from self._time_outs(last, now)
            yield from self._release_time_outs(last, now)
            for index in sorted(set(now.blowing) - set(last.blowing)):
                yield f"{display_name(self._parts[index][0])} is blown off."
        if old is not new:
            command = Command.NONE if now.command in _OF_THE_CHANGER else now.command
            yield transition(old.name, new.name, command, "" if new in _QUIET else now.reason)

    def _time_outs(self, last: Status, now: Status) -> Iterator[str]:
        """Attempts that have failed, by their time-out or with nothing gripped; also the last one."""
        if last.ee != EndEffectorState.GRIPPING:
            self._timed_out.clear()
            return
        gave_up = now.ee != last.ee and now.cause in (Cause.TIMED_OUT, Cause.EMPTY)
        for index, (name, part) in enumerate(self._parts):
            attempt = last.steps[index].attempts if index < len(last.steps) else 0
            again = now.ee == last.ee and not now.steps[index].confirmed and last.outputs[index]
            again = again and (not now.outputs[index] or now.steps[index].attempts > attempt)
            if (again or (gave_up and now.cause_at == index)) and (index, attempt) not in self._timed_out:
                self._timed_out.add((index, attempt))
                empty = f"{display_name(name)} {kind_of(part).empty}"
                slow = f"{display_name(name)} was not confirmed within {part.timeout_s:g} s"
                failed = empty if f"{empty}." in now.alarms else slow
                yield f"{failed}: attempt {attempt} of {part.attempts}."

    def _release_time_outs(self, last: Status, now: Status) -> Iterator[str]:
        """Feedback that is still there when its time is over, and the release goes on."""
        off = [i for i in range(len(now.outputs)) if last.outputs[i] and not now.outputs[i]]
        releasing = EndEffectorState.RELEASING in (last.ee, now.ee)
        before, goes_on = self._released, bool(off) or now.ee != EndEffectorState.RELEASING
        if releasing and before is not None and goes_on and now.evidence[before] != Evidence.GONE:
            name, part = self._parts[before]
            yield f"{display_name(name)} was not gone within {part.release_s:g} s."
        if goes_on:
            self._released = off[-1] if off and now.ee == EndEffectorState.RELEASING else None
