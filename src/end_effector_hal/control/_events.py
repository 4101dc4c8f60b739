"""The events of a tool: a table maps the edges of its automata to events.

The edges are those of `Gripper` and `Changer` in the UPPAAL file. The terminal, the logs of the nodes and the page use
these events: none of them detects an attempt or a time-out on its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

from end_effector_hal.vocabulary import Cause
from timed_automata import Change, Step


class EventKind(StrEnum):
    """The kinds of events of a tool."""

    COMMAND_ACCEPTED = "command accepted"
    ATTEMPT_BEGAN = "attempt began"
    CONFIRMED = "confirmed"
    TIMED_OUT = "timed out"
    CLOSED_ON_NOTHING = "closed on nothing"
    LOST = "lost"
    ACTIVATION_REFUSED = "activation refused"
    DEACTIVATED = "deactivated"
    NOT_GONE = "not gone"
    NOT_PROVEN = "tool changer not proven"
    BLOWN_OFF = "blown off"
    STATE_CHANGED = "state changed"
    CHANGER_CHANGED = "tool changer changed"


@dataclass(frozen=True, slots=True)
class ToolEvent:
    """One event of a step of the automata.

    Attributes:
        at: time of the step, µs.
        kind: the kind of the event.
        actuator: position of the actuator in the sequence; for a change of state, that of its cause; -1: no single
            actuator.
        attempt: number of the attempt in this grip, from 1; 0: the event belongs to no attempt.
        old, new: the state before and after, in the integers of Table II; -1: no state has changed.
        cause: the reason why a grip or a release has ended with this change of state.
        command: the name of the channel of an accepted command.
    """

    at: int
    kind: EventKind
    actuator: int = -1
    attempt: int = 0
    old: int = -1
    new: int = -1
    cause: Cause = Cause.NONE
    command: str = ""


_K = EventKind
COMMANDS = ("grip", "drop", "cancel", "resume", "lock", "unlock", "arm", "reset")
"""The channels of the commands."""
_STATES = {"ee": _K.STATE_CHANGED, "changer": _K.CHANGER_CHANGED}
EDGES: Mapping[tuple[str, str, str], tuple[EventKind, ...]] = {
    ("Activate", "Step", "activate"): (_K.ATTEMPT_BEGAN,),
    ("Step", "Activate", "engaged"): (_K.CONFIRMED,),
    ("Step", "Decide", "engaged"): (_K.CONFIRMED,),
    ("Step", "Reset", "deactivate"): (_K.TIMED_OUT,),
    ("Step", "Step", "again"): (_K.TIMED_OUT, _K.ATTEMPT_BEGAN),
    ("Step", "Abort", ""): (_K.TIMED_OUT,),
    ("Empty", "Reset", "deactivate"): (_K.CLOSED_ON_NOTHING,),
    ("Empty", "Abort", ""): (_K.CLOSED_ON_NOTHING,),
    ("Step", "Abort", "lost"): (_K.LOST,),
    ("Reset", "Abort", "lost"): (_K.LOST,),
    ("Gripped", "GripError", "lost"): (_K.LOST,),
    ("Gripped", "Abort", "lost"): (_K.LOST,),
    ("Step", "Refused", "grip_refused"): (_K.ACTIVATION_REFUSED,),
    ("Gripped", "GripError", "grip_refused"): (_K.ACTIVATION_REFUSED,),
    ("Refused", "Abort", "deactivate"): (_K.DEACTIVATED,),
    ("Unwind", "Check", "deactivate"): (_K.DEACTIVATED,),
    ("Gap", "Blowing", "blow_on"): (_K.BLOWN_OFF,),
    ("Releasing", "Unwind", ""): (_K.NOT_GONE,),
    ("Clearing", "Unwind", ""): (_K.NOT_GONE,),
    ("Unlocking", "Relock", ""): (_K.NOT_PROVEN,),
    ("Locking", "Fault", ""): (_K.NOT_PROVEN,),
}
"""Events of an edge of `Gripper` or `Changer`, by source, target and channel; empty: no channel."""
FAILURES = (_K.TIMED_OUT, _K.CLOSED_ON_NOTHING, _K.NOT_GONE, _K.NOT_PROVEN)
"""Events of a time-out that has passed or an attempt that has failed."""
_ATTEMPTS = (_K.ATTEMPT_BEGAN, _K.CONFIRMED, _K.TIMED_OUT, _K.CLOSED_ON_NOTHING)
_CAUSES = {int(each): each for each in Cause}  # a lookup costs less than a conversion


class EventReader:
    """Derives the events of a tool from the steps of its automata, given in their order.

    Args:
        variables: the variables of the automata before the first step; default: those at the start.
    """

    MEMORY: ClassVar = {"_attempt": int, "_last": int, "_cause": int, "_cause_at": int}
    _NAMES: ClassVar = {
        "Gripper.attempt": "_attempt",
        "Gripper.last": "_last",
        "cause": "_cause",
        "cause_at": "_cause_at",
    }

    def __init__(self, variables: Mapping[str, int] | None = None) -> None:
        self._attempt, self._last, self._cause, self._cause_at = 0, 0, 0, -1
        for name in self._NAMES.keys() & (variables or {}).keys():
            setattr(self, self._NAMES[name], (variables or {})[name])

    def of(self, step: Step, at: int) -> tuple[ToolEvent, ...]:
        """Return the events of the next step, taken at ``at`` µs."""
        before = self._attempt
        found: list[ToolEvent] = []
        changed: list[Change] = []
        for change in step.changes:
            if (own := self._NAMES.get(change.name)) is not None:
                setattr(self, own, change.new)
            elif change.name in _STATES:
                changed.append(change)
        if step.received in COMMANDS:
            found.append(ToolEvent(at, _K.COMMAND_ACCEPTED, command=step.received or ""))
        channel, _, index = (step.received or step.sent or "").rstrip("]").partition("[")
        for edge in step.edges:
            for kind in EDGES.get((edge.source, edge.target, channel), ()):
                if index:
                    who = int(index)
                elif kind in (_K.NOT_GONE, _K.NOT_PROVEN):
                    who = self._last if edge.source == "Releasing" else -1
                else:
                    who = self._cause_at
                attempt = self._attempt if kind is _K.ATTEMPT_BEGAN else before
                found.append(ToolEvent(at, kind, who, attempt if kind in _ATTEMPTS else 0))
        for change in changed:
            cause, who = (self._cause, self._cause_at) if change.name == "ee" else (0, -1)
            found.append(ToolEvent(at, _STATES[change.name], who, 0, change.old, change.new, _CAUSES[cause]))
        return tuple(found)


def restart_events(ee: int, changer: int, at: int) -> tuple[ToolEvent, ...]:
    """Return the events of a restart at ``at`` µs; ``ee``, ``changer``: the states that were published last."""
    states = {_K.STATE_CHANGED: ee, _K.CHANGER_CHANGED: changer}
    return tuple(ToolEvent(at, kind, old=old, new=0) for kind, old in states.items() if old)
