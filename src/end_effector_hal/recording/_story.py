"""The parts of a story: grips with their attempts, releases and losses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from end_effector_hal.vocabulary import EndEffectorState, display_name


class AttemptOutcome(StrEnum):
    """The end of an attempt of one actuator."""

    CONFIRMED = "confirmed"
    TIMED_OUT = "timed out"
    EMPTY = "gripped nothing"
    DEACTIVATED = "deactivated"
    PENDING = "still pending"


FAILED = (AttemptOutcome.TIMED_OUT, AttemptOutcome.EMPTY)


class GripDecision(StrEnum):
    """The end of a grip."""

    GRIPPED = "GRIPPED"
    ABORTED = "ABORTED"
    CANCELLED = "CANCELLED"
    STOPPED = "STOPPED"
    UNFINISHED = "UNFINISHED"


class ReleaseCause(StrEnum):
    """The cause of an unwinding."""

    ABORT = "abort"
    CANCEL = "cancel"
    DROP = "drop"
    LOSS = "loss"
    """A held part was lost, and the other actuators are released, as declared."""
    START = "start"
    """Outputs were found active at the start."""


@dataclass(frozen=True)
class Attempt:
    """One activation of one actuator; times in seconds since the start of the recording.

    ``number`` counts the attempts of this actuator in this grip from 1; ``of`` is the number of failed attempts that
    aborts the grip, None if run.json does not state it.
    """

    actuator: str
    number: int
    start_s: float
    end_s: float | None
    outcome: AttemptOutcome
    of: int | None = None

    @property
    def length_s(self) -> float | None:
        """Duration of the attempt, s; None while it is pending."""
        return None if self.end_s is None else self.end_s - self.start_s

    def __str__(self) -> str:
        """Return text such as ``Cylinder, attempt 2 of 3: confirmed after 0.42 s``."""
        of = f" of {self.of}" if self.of else ""
        after = "" if self.length_s is None else f" after {self.length_s:.2f} s"
        return f"{display_name(self.actuator)}, attempt {self.number}{of}: {self.outcome}{after}"


@dataclass(frozen=True)
class Reset:
    """The pause of one actuator between two attempts."""

    actuator: str
    start_s: float
    end_s: float

    @property
    def length_s(self) -> float:
        """Time for which the actuator was inactive, s."""
        return self.end_s - self.start_s


@dataclass(frozen=True)
class Release:
    """An unwinding.

    ``deactivated`` lists the actuators in order of time; ``ended`` is the state that ended it, None while it still
    runs.
    """

    cause: ReleaseCause
    start_s: float
    end_s: float | None
    deactivated: tuple[str, ...]
    ended: EndEffectorState | None

    def in_reverse(self, sequence: tuple[str, ...]) -> bool:
        """Whether the actuators were deactivated in the reverse order of the sequence."""
        order = [sequence.index(name) for name in self.deactivated if name in sequence]
        return order == sorted(order, reverse=True)


@dataclass(frozen=True)
class Grip:
    """One grip, from GRIPPING to its decision.

    ``culprit`` is the actuator whose last failed attempt aborted the grip; ``waiting`` is the actuator that was
    pending when the grip ended for another reason.
    """

    start_s: float
    decided_s: float | None
    decision: GripDecision
    attempts: tuple[Attempt, ...]
    resets: tuple[Reset, ...]
    culprit: str | None = None
    waiting: str | None = None
    part: str = ""
    """Name of the part; empty: it has none."""

    def of(self, actuator: str) -> tuple[Attempt, ...]:
        """Return the attempts of one actuator."""
        return tuple(attempt for attempt in self.attempts if attempt.actuator == actuator)

    @property
    def failed(self) -> tuple[Attempt, ...]:
        """The attempts that timed out or gripped nothing."""
        return tuple(attempt for attempt in self.attempts if attempt.outcome in FAILED)

    @property
    def timeouts(self) -> tuple[Attempt, ...]:
        """The attempts that timed out."""
        return tuple(attempt for attempt in self.attempts if attempt.outcome is AttemptOutcome.TIMED_OUT)

    @property
    def attempts_by_actuator(self) -> Mapping[str, int]:
        """Number of attempts of each actuator."""
        return {attempt.actuator: attempt.number for attempt in self.attempts}

    @property
    def first_attempt(self) -> bool:
        """Whether the grip succeeded, and every actuator was confirmed on its first attempt."""
        return self.decision is GripDecision.GRIPPED and set(self.attempts_by_actuator.values()) <= {1}

    @property
    def confirm_s(self) -> Mapping[str, float]:
        """Time from the activation to the confirmation in the attempt that was confirmed, s, by actuator."""
        confirmed = (each for each in self.attempts if each.outcome is AttemptOutcome.CONFIRMED)
        return {each.actuator: each.length_s for each in confirmed if each.length_s is not None}


@dataclass(frozen=True)
class Loss:
    """The loss of a held part; ``actuator`` is the actuator that lost its confirmation, empty if unknown."""

    time_s: float
    actuator: str = ""

    @property
    def who(self) -> str:
        """Name of the actuator for display; empty: unknown."""
        return display_name(self.actuator)


@dataclass(frozen=True)
class Moment:
    """A moment that a figure marks."""

    time_s: float
    kind: str
    text: str


@dataclass(frozen=True)
class Story:
    """The events of a recording in order of time.

    ``losses`` are the losses of held parts; ``adopted`` is the state found at the start, if any.
    """

    actuators: tuple[str, ...]
    grips: tuple[Grip, ...]
    releases: tuple[Release, ...]
    losses: tuple[Loss, ...]
    adopted: EndEffectorState | None
    final: EndEffectorState | None
    moments: tuple[Moment, ...]
    verdict: str

    @property
    def lost_s(self) -> tuple[float, ...]:
        """The times at which a held part was lost."""
        return tuple(loss.time_s for loss in self.losses)

    @property
    def attempts(self) -> tuple[Attempt, ...]:
        """Every attempt of every grip."""
        return tuple(attempt for grip in self.grips for attempt in grip.attempts)

    @property
    def timeouts(self) -> tuple[Attempt, ...]:
        """Every attempt that timed out."""
        return tuple(attempt for grip in self.grips for attempt in grip.timeouts)

    @property
    def resets(self) -> tuple[Reset, ...]:
        """Every pause between two attempts."""
        return tuple(reset for grip in self.grips for reset in grip.resets)
