"""Adopt the lines as a program finds them, and compare them with what was written after the line arbiter was lost."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.errors import ArbiterError, LineBusyError, WireError
from end_effector_hal.runtime.boundary import AnyController
from end_effector_hal.runtime.outputs import DECLARED_DEAD, RETRY_US, LineWriter, Outputs, unknown
from end_effector_hal.vocabulary import Alarm, EndEffectorState


class DeclaredDeadError(Exception):
    """The lines are not as the program left them: it must restart; the text is the reason."""


class Adoption:
    """Adopts the lines as soon as they can be read, and compares them after the line arbiter was lost.

    One object serves a program from its start, or a restart, to its next restart.

    Args:
        controller: a controller that has not begun.
        outputs: the writer of its statuses.
        lines: the line arbiter.
        activated: lines that count as active while their level cannot be read, whatever their sensors show.
        grip_error: whether GRIP_ERROR was latched before the restart; it stays latched.

    Attributes:
        begun: whether the lines are adopted.
        withholds: whether a status with a held part is not published yet, because a write waits for its lines to
            settle.
        alarm: why the lines are not adopted; None: no obstacle is known.
    """

    def __init__(
        self,
        controller: AnyController,
        outputs: Outputs,
        lines: LineWriter,
        activated: frozenset[str] = frozenset(),
        *,
        grip_error: bool = False,
    ) -> None:
        self._activated, self.grip_error = activated, grip_error
        self.controller, self.outputs, self._lines = controller, outputs, lines
        self.begun = False
        self.withholds = False
        self.alarm: Alarm | None = None
        self._unreachable = False
        self._begin_at: int | None = None
        self._withheld: tuple[ToolEvent, ...] = ()

    @property
    def lost(self) -> bool:
        """Whether the line arbiter is lost: the levels of the lines are unknown now."""
        return self.outputs.lost or self._unreachable

    @property
    def due(self) -> int | None:
        """Time of the next action that needs no event, µs; None: there is none."""
        at = self.controller.deadline if self.begun else self._begin_at
        settles_at = self.outputs.settles_at if self.withholds else None
        return min(
            (each for each in (at, self.outputs.retry_at, settles_at) if each is not None), default=None
        )

    def begin(self, at: int, sensor_fault: Callable[[], bool]) -> list[Status]:
        """Adopt the lines as they are; if that fails, set the alarm and schedule a retry.

        Args:
            at: time, µs.
            sensor_fault: returns whether a sensor fault was latched before; may raise WireError.
        """
        try:
            levels = {**dict.fromkeys(self._activated, True), **self._lines.levels()}
            found, part = sensor_fault(), self._lines.recorded_part()
        except WireError as error:
            self._unreachable = isinstance(error, ArbiterError)
            self.alarm = (
                unknown(error) if self._unreachable else Alarm("lines.not_adopted", "", {"text": str(error)})
            )
            self._begin_at = at + RETRY_US
            return []
        self.begun, self._unreachable, self.alarm, self._begin_at = True, False, None, None
        self.outputs.found(levels, self.controller.status())
        return self.controller.start(levels, at, sensor_fault=found, grip_error=self.grip_error, part=part)

    def time_passed(self, at: int) -> list[Status]:
        """Do everything that is due at ``at``; the lines must be adopted."""
        settled = self.withholds and at >= (self.outputs.settles_at or at)
        if not self.outputs.lost and (settled or at >= (self.outputs.retry_at or at + 1)):
            self.outputs.retry(self.controller.status(), at)
        return self.controller.advance(at)

    def look(self, at: int) -> None:
        """Check whether the line arbiter answers, so that a command does not begin while it is lost."""
        if self.begun and not self.outputs.lost:
            try:
                self._lines.levels()
            except WireError as error:
                self.outputs.lose(error, at)

    def lose(self, error: ArbiterError, at: int) -> None:
        """Note that the connection to the line arbiter was lost."""
        if self.begun:
            self.outputs.lose(error, at)
            with suppress(WireError):
                self._lines.levels()  # a client reports each loss once more, to its next caller

    def compare(self, statuses: list[Status], published: Status, at: int) -> list[Status]:
        """Return the statuses that may be published after the line arbiter was lost.

        Args:
            statuses: the new statuses.
            published: the status that was published last.
            at: time, µs.

        Raises:
            DeclaredDeadError: the lines are not as they were left.
        """
        if at >= (self.outputs.retry_at or 0):
            try:
                gripping = self.outputs.mapping.gripping(self.controller.status())
                if not self.outputs.agree(at, gripping=gripping):
                    raise DeclaredDeadError(self.outputs.disagreement)
                self.outputs.retry(self.controller.status(), at)
            except LineBusyError as error:
                # its will is being executed, or somebody else has its lines
                raise DeclaredDeadError(f"{DECLARED_DEAD} {error}") from error
            except WireError as error:
                self.outputs.alarm = unknown(error)
        if not self.outputs.lost:
            return self._filtered([*statuses, self.now(at)])
        # nothing is reported as held before the arbiter has the will that holds: until then it may unwind
        return self._filtered(statuses, lambda status: published.held or not status.held)

    def after_writes(self, statuses: list[Status], published: Status, at: int) -> list[Status]:
        """Return the statuses that may be published after the arbiter's reply; ``published``: the last published one.

        A requested deactivation may have to wait after the last change of its line (IL-10). Until it is over, no
        status with a held part is published, because the line that would hold it is going inactive, and no end of a
        release, because the line is still active.
        """
        if self.outputs.settles_at is None:
            if self.withholds:
                self.withholds = False
                return self._filtered([*statuses, self.now(at)])
            return statuses
        # in STAND_BY all the time: then it is the line of the tool changer that settles
        rests = all(status.ee is EndEffectorState.STAND_BY for status in (published, *statuses))
        told = self._filtered(
            statuses,
            lambda status: (
                (published.held or not status.held) and (rests or status.ee is not EndEffectorState.STAND_BY)
            ),
        )
        self.withholds = self.withholds or len(told) < len(statuses)
        return told

    def _filtered(
        self, statuses: list[Status], may_be_published: Callable[[Status], bool] = lambda _: True
    ) -> list[Status]:
        """Return the statuses that may be published; the events of the others are moved to the next status that may."""
        found = []
        for status in statuses:
            events = (*self._withheld, *status.events)
            if may_be_published(status):
                found.append(replace(status, events=events))
                self._withheld = ()
            else:
                self._withheld = events
        return found

    def now(self, at: int) -> Status:
        """Return the current status; before the lines are adopted, its time is set to ``at``."""
        status = self.controller.status()
        return status if self.begun else replace(status, at=at)
