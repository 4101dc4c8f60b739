"""Lines of text about transitions, time-outs and refusals, for the log of a node and for a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from end_effector_hal.control._events import EventKind, ToolEvent
from end_effector_hal.control._status import Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState, display_name

from ._changer_reasons import explain_changer

_QUIET = (EndEffectorState.GRIPPING, EndEffectorState.GRIPPED)
"""States in which the reason of an earlier end is no longer of interest."""
_OF_THE_CHANGER = (Command.LOCK, Command.UNLOCK)
"""Commands of the tool changer; they cause no transition of the end-effector."""


def transition(old: str, new: str, command: int, reason: str, part: str = "") -> str:
    """Return a transition such as ``STAND_BY -> GRIPPING (GRIP panel)``, with the reason if there is one."""
    named = f" {part}" if part and command == Command.GRIP else ""
    doing = f" ({Command(command).name}{named})" if command != Command.NONE else ""
    return f"{old} -> {new}{doing}{f': {reason}' if reason else ''}"


def refused(what: str, why: str) -> str:
    """Return the text of a refusal, such as ``refused: drop. Nothing is held …``."""
    return f"refused: {what}. {why}"


def unanswered(what: str, why: str) -> str:
    """Return the text of a missing answer, such as ``unreachable: drop. The line arbiter is lost: …``."""
    return f"unreachable: {what}. {why}"


def event_lines(description: Description, status: Status) -> Iterator[str]:
    """Yield the lines for the events that led to a status, in order of time."""
    yield from filter(None, (event_line(description, status, event) for event in status.events))


def event_line(description: Description, status: Status, event: ToolEvent) -> str:
    """Return the line for one event of a status; empty: it has none."""
    tool = description.for_part(status.part)
    return event_text(tool, event) or _transition(description, status, event)


def event_text(description: Description, event: ToolEvent) -> str:
    """Return a sentence for a time-out, a grip of nothing, or a blow-off; empty for all other events."""
    return _TEXTS[event.kind](description, event) if event.kind in _TEXTS else ""


def _timed_out(description: Description, event: ToolEvent) -> str:
    name, actuator = description.ordered[event.actuator]
    slow = f"{display_name(name)} was not confirmed within {actuator.timeout_s:g} s"
    return f"{slow}: attempt {event.attempt} of {actuator.attempts}."


def _closed_on_nothing(description: Description, event: ToolEvent) -> str:
    name, actuator = description.ordered[event.actuator]
    return f"{display_name(name)} {kind_of(actuator).empty}: attempt {event.attempt} of {actuator.attempts}."


def _not_gone(description: Description, event: ToolEvent) -> str:
    if event.actuator < 0:
        return "Feedback that came back during the release was not gone in time."
    name, actuator = description.ordered[event.actuator]
    return f"{display_name(name)} was not gone within {actuator.release_s:g} s."


def _blown_off(description: Description, event: ToolEvent) -> str:
    return f"{display_name(description.sequence[event.actuator])} is blown off."


_TEXTS: Mapping[EventKind, Callable[[Description, ToolEvent], str]] = {
    EventKind.TIMED_OUT: _timed_out,
    EventKind.CLOSED_ON_NOTHING: _closed_on_nothing,
    EventKind.NOT_GONE: _not_gone,
    EventKind.BLOWN_OFF: _blown_off,
}


def _transition(description: Description, status: Status, event: ToolEvent) -> str:
    """Return the line for a change of a state; empty for all other events."""
    if event.kind is EventKind.STATE_CHANGED:
        old, new = EndEffectorState(event.old), EndEffectorState(event.new)
        command = Command.NONE if status.command in _OF_THE_CHANGER else status.command
        reason = "" if new in _QUIET else status.reason
        return transition(old.name, new.name, command, reason, status.part)
    if event.kind is EventKind.CHANGER_CHANGED:
        before, now = ChangerState(event.old), ChangerState(event.new)
        command = status.command if status.command in _OF_THE_CHANGER else Command.NONE
        said = transition(before.name, now.name, command, _why(description, now, status))
        return f"tool changer: {said}"
    return ""


def _why(description: Description, changer: ChangerState, now: Status) -> str:
    if changer is ChangerState.FAULT:
        return explain_changer(description, now.changer_fault)
    stanza = description.tool_changer
    if changer is not ChangerState.UNKNOWN or stanza is None:
        return ""
    stale = [bit for bit in (stanza.locked_bit, stanza.unlocked_bit) if bit in now.stale]
    return f"no valid reading of {', '.join(stale)}" if stale else ""
