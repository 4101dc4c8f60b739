"""The status of a running tool: one immutable snapshot per step of its automata."""

from __future__ import annotations

from dataclasses import dataclass, replace

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
    """A report on one step of the running or last grip."""

    name: str
    attempts: int = 0
    seconds: float = 0.0
    """Time from its first activation to its confirmation, or until now, s."""
    confirmed: bool = False


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a command: whether it was accepted, and if not, why.

    Attributes:
        decided: False if no answer came in time, so that the command may still be executed; or if the line arbiter is
            lost, and the command is not executed.
        count: number of the first published status that is certain to follow the acceptance.
    """

    accepted: bool
    reason: str = ""
    decided: bool = True
    count: int = 0


@dataclass(frozen=True, slots=True)
class Status:
    """The complete status after one step; times are in µs on the monotonic clock."""

    at: int
    ee: EndEffectorState
    command: Command
    actuators: tuple[int, ...]
    """State of each actuator in Table II; its kind has the names."""
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
    part: str = ""
    """Name of the part that is gripped, held or released; empty: none, or it has no name."""
    kept: tuple[int, ...] = ()
    """Actuators, by position in the sequence, that the present unwinding leaves active, as declared."""
    blowing: tuple[int, ...] = ()
    """Actuators, by position in the sequence, whose part is being blown off."""
    dropped: int = -1
    """The actuator that the present Drop has deactivated last, by position in the sequence; -1: none."""
    secure: bool = False
    maintenance: bool = False
    adopted: bool = False
    """Whether the automata have adopted the lines; before that nothing is written."""
    changer: ChangerState = ChangerState.UNKNOWN
    unlock_output: bool = False
    changer_fault: ChangerFault = ChangerFault.NONE
    """Why the tool changer is in FAULT."""
    changer_reason: str = ""
    """Why the tool changer is not locked, a sentence."""
    vented: bool = False
    """Whether nothing is gripped, as IL-01 requires."""
    armed: bool = False
    """Whether an unlock is armed (IL-02)."""
    link_up: bool = False
    stale: tuple[str, ...] = ()
    missed: int = 0
    worst_late_us: int = 0
    refused_frames: int = 0
    """Number of frames refused because of their stamp, since the start."""
    alarms: tuple[Alarm, ...] = ()
    steps: tuple[StepReport, ...] = ()
    events: tuple[ToolEvent, ...] = ()
    """Events between the previous status and this one, in order."""
    begun: int = 0
    """Time at which its program began; 0: no program has published it."""
    count: int = 0
    """Number of this status since then; statuses that differ only in an alarm about a listener have the same."""

    @property
    def arbiter_lost(self) -> bool:
        """Whether the line arbiter is lost, so that ``held`` and the outputs are the last known ones."""
        return self.alarm(ARBITER_LOST) is not None

    @property
    def alarm_texts(self) -> tuple[str, ...]:
        """The alarms as sentences."""
        return tuple(map(str, self.alarms))

    def alarm(self, *ids: str, about: str | None = None) -> Alarm | None:
        """Return the first alarm with one of these ids, about this thing (None: any thing), or None."""
        found = (each for each in self.alarms if each.id in ids and about in (None, each.about))
        return next(found, None)


def unknown_now(status: Status) -> Status:
    """Return the status of a tool whose program does not run: the line arbiter goes on holding a held part.

    The states and the evidence are unknown, and lifting is not allowed. The outputs and ``held`` keep their last known
    values.
    """
    return replace(
        status, ee=EndEffectorState.OFF, command=Command.NONE, evidence=(Evidence.UNKNOWN,) * len(status.evidence),
        step=-1, deadline=None, lift_allowed=False, secure=False, maintenance=False, link_up=False,
        changer=ChangerState.UNKNOWN, events=(), count=0,
    )  # fmt: skip
