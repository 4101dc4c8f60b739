"""From the lines as a program finds them to its next restart: a controller, its outputs, and what is known of both."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.errors import ArbiterError, LineBusyError, WireError
from end_effector_hal.runtime.boundary import AnyController
from end_effector_hal.runtime.outputs import DECLARED_DEAD, RETRY_US, LineWriter, Outputs, unknown
from end_effector_hal.vocabulary import Alarm, EndEffectorState


class DeclaredDeadError(Exception):
    """The lines are not as the program has left them: it must restart, for this reason."""


class Adoption:
    """Adopts the lines as soon as they can be read, and compares them after the line arbiter was lost.

    Args:
        controller: one that has not begun.
        outputs: of its statuses.
        lines: the line arbiter.
        activated: lines that count as active where nobody knows how they stand, whatever their sensors show.

    Attributes:
        begun: whether the lines are adopted.
        withholds: whether something held is not told yet, because a write waits for its lines to settle.
        alarm: why they are not; None: nothing is known to be in the way.
    """

    def __init__(
        self,
        controller: AnyController,
        outputs: Outputs,
        lines: LineWriter,
        activated: frozenset[str] = frozenset(),
    ) -> None:
        self._activated = activated
        self.controller, self.outputs, self._lines = controller, outputs, lines
        self.begun = False
        self.withholds = False
        self.alarm: Alarm | None = None
        self._unreachable = False
        self._begin_at: int | None = None
        self._ahead_of: object = None
        self._ahead: Iterator[object] = iter(())
        self._withheld: tuple[ToolEvent, ...] = ()

    @property
    def lost(self) -> bool:
        """Whether the line arbiter is lost: nothing is known of the lines now."""
        return self.outputs.lost or self._unreachable

    @property
    def due(self) -> int | None:
        """µs at which something happens by itself."""
        at = self.controller.deadline if self.begun else self._begin_at
        settles_at = self.outputs.settles_at if self.withholds else None
        return min(
            (each for each in (at, self.outputs.retry_at, settles_at) if each is not None), default=None
        )

    def begin(self, at: int, sensor_fault: Callable[[], bool], peer: Mapping[str, int]) -> list[Status]:
        """Adopt the lines as they are, or find an obstacle and have it tried again.

        Args:
            at: µs.
            sensor_fault: whether one was latched before; raises WireError.
            peer: what is known of the other program.
        """
        try:
            levels = {**dict.fromkeys(self._activated, True), **self._lines.levels()}
            found = sensor_fault()
        except WireError as error:
            self._unreachable = isinstance(error, ArbiterError)
            self.alarm = (
                unknown(error) if self._unreachable else Alarm("lines.not_adopted", "", {"text": str(error)})
            )
            self._begin_at = at + RETRY_US
            return []
        self.begun, self._unreachable, self.alarm, self._begin_at = True, False, None, None
        self.outputs.found(levels, self.controller.status())
        statuses = self.controller.start(levels, at, sensor_fault=found)
        return statuses + (self.controller.update_peer(peer, at) if peer else [])

    def time_passed(self, at: int) -> list[Status]:
        """What is due at ``at``, once the lines are adopted."""
        settled = self.withholds and at >= (self.outputs.settles_at or at)
        if not self.outputs.lost and (settled or at >= (self.outputs.retry_at or at + 1)):
            self.outputs.retry(self.controller.status(), at)
        return self.controller.advance(at)

    def look(self, at: int) -> None:
        """Whether the line arbiter answers: a command that finds it lost is not even begun."""
        if self.begun and not self.outputs.lost:
            try:
                self._lines.levels()
            except WireError as error:
                self.outputs.lose(error, at)

    def lose(self, error: ArbiterError, at: int) -> None:
        """The connection to the line arbiter was lost."""
        if self.begun:
            self.outputs.lose(error, at)
            with suppress(WireError):
                self._lines.levels()  # a client reports each loss once more, to its next caller

    def compare(self, statuses: list[Status], published: Status, at: int) -> list[Status]:
        """What may be published of statuses after the line arbiter was lost; ``published``: what was before.

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
        """What may be published of statuses after the line arbiter has replied; ``published``: what was before.

        A deactivation that was asked for may wait behind its line's last change (IL-10). Nothing is told as held before
        it is over, for until then the line of what would be held goes inactive; nor as at rest, for it is active.
        """
        if self.outputs.settles_at is None:
            if self.withholds:
                self.withholds = False
                return self._filtered([*statuses, self.now(at)])
            return statuses
        told = self._filtered(
            statuses,
            lambda status: (published.held or not status.held) and status.ee is not EndEffectorState.STAND_BY,
        )
        self.withholds = self.withholds or len(told) < len(statuses)
        return told

    def _filtered(
        self, statuses: list[Status], may_be_published: Callable[[Status], bool] = lambda _: True
    ) -> list[Status]:
        """Those of some statuses that may be published; the events of the others go with the next one that may."""
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
        """The status; before the lines are adopted nothing else gives it a time."""
        status = self.controller.status()
        return status if self.begun else replace(status, at=at)

    def look_ahead(self) -> bool:
        """Have the automata look a little further ahead of where they stand; whether there is more."""
        state = self.controller.discrete_state
        if state != self._ahead_of:
            self._ahead_of, self._ahead = state, self.controller.look_ahead()
        return next(self._ahead, None) is not None
