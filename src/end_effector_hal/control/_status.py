"""What a running program says of itself: one immutable snapshot per step of its automata."""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.vocabulary import (
    ARBITER_LOST,
    Alarm,
    Cause,
    ChangerFault,
    ChangerState,
    Command,
    EndEffectorState,
    Evidence,
)

from ._events import ToolEvent


@dataclass(frozen=True, slots=True)
class StepReport:
    """One step of the running or last grip."""

    name: str
    attempts: int = 0
    seconds: float = 0.0
    """From its first activation to its confirmation, or until now."""
    confirmed: bool = False


@dataclass(frozen=True, slots=True)
class Answer:
    """Whether a command was taken, and if not, why in words.

    Attributes:
        decided: False when no answer came in time, and the command may be executed all the same; or when the line
            arbiter is lost, and it is not executed.
        count: the number of the first status that is certain to follow the acceptance, where statuses are numbered.
    """

    accepted: bool
    reason: str = ""
    decided: bool = True
    count: int = 0


@dataclass(frozen=True, slots=True)
class Status:
    """Everything that can be said after one step; times in µs on the monotonic clock."""

    at: int
    ee: EndEffectorState
    command: Command
    actuators: tuple[int, ...]
    """The state of each in Table II; its kind has the words."""
    outputs: tuple[bool, ...]
    evidence: tuple[Evidence, ...]
    step: int = -1
    attempt: int = 0
    attempts_allowed: int = 0
    deadline: int | None = None
    cause: Cause = Cause.NONE
    cause_at: int = -1
    reason: str = ""
    lift_allowed: bool = False
    held: bool = False
    kept: tuple[int, ...] = ()
    """Actuators, by their place in the sequence, that the unwinding which runs leaves active, as declared."""
    blowing: tuple[int, ...] = ()
    """Actuators, by their place in the sequence, that are being blown off."""
    dropped: int = -1
    """The actuator that a Drop has deactivated last, by its place in the sequence, until it is over; -1: none."""
    secure: bool = False
    maintenance: bool = False
    changer: ChangerState = ChangerState.UNKNOWN
    unlock_output: bool = False
    changer_fault: ChangerFault = ChangerFault.NONE
    """Why the tool changer is FAULT."""
    vented: bool = False
    """Nothing is gripped, as IL-01 asks it."""
    armed: bool = False
    """An unlock was armed (IL-02)."""
    link_up: bool = False
    stale: tuple[str, ...] = ()
    missed: int = 0
    worst_late_us: int = 0
    refused_frames: int = 0
    """Frames that did not count because of their stamp, since the start."""
    alarms: tuple[Alarm, ...] = ()
    steps: tuple[StepReport, ...] = ()
    events: tuple[ToolEvent, ...] = ()
    """What has led from the status before to this one, in order."""

    @property
    def arbiter_lost(self) -> bool:
        """Whether ``held`` and the outputs are the last known ones, and not known now."""
        return self.alarm(ARBITER_LOST) is not None

    @property
    def alarm_texts(self) -> tuple[str, ...]:
        """The alarms as sentences."""
        return tuple(map(str, self.alarms))

    def alarm(self, *ids: str, about: str | None = None) -> Alarm | None:
        """The first alarm with one of some ids, about something or about anything (None); None: there is none."""
        found = (each for each in self.alarms if each.id in ids and about in (None, each.about))
        return next(found, None)


def told_to_grip(status: Status) -> dict[str, int]:
    """The tool changer's variables in the gripping network; loose: unlock output active, or FAULT."""
    loose = status.unlock_output or status.changer is ChangerState.FAULT
    return {"unlock_valve": int(status.unlock_output), "loose": int(loose)}
