"""The program of the tool changer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar, Protocol

from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.errors import WireError
from end_effector_hal.runtime.boundary import NULL_RECORDER, Recorder
from end_effector_hal.runtime.outputs import RESTARTED, RETRY_US, ChangerOutputs, LineWriter, OutputMapping
from end_effector_hal.sensing import FrameJudge
from end_effector_hal.vocabulary import Alarm, EndEffectorState
from end_effector_hal.wires import now_us

from ._inline_worker import InlineWorker
from ._latest_status import LatestStatus, Listener
from ._program import Program
from ._sensor_fault import FaultKeeper, SensorFault
from ._serial_worker import SerialWorker

FALL_S = 0.5
"""Longest time in which a vacuum that has just counted as gone falls below the limit of IL-01, s."""
LAG_S = 0.15
"""Longest delay until the end of a release is visible to this program, s."""
_MAY_RELEASE = (EndEffectorState.STAND_BY, EndEffectorState.OFF, EndEffectorState.RELEASING)


def await_release(latest: LatestStatus, changer: ToolChanger) -> None:
    """Wait until the release is proven or cannot be, for no longer than the fall and the proof take.

    Feedback that is still present is no reason to stop: the last frame of the release may not have arrived yet.
    """
    latest.wait(release_is_decided, longest_release_s(changer))


def longest_release_s(changer: ToolChanger) -> float:
    """Return the longest wait of an unlock, s."""
    return LAG_S + FALL_S + changer.vented_s


def release_is_decided(status: Status) -> bool:
    """Return whether the release is proven, or cannot be."""
    return status.vented or status.ee not in _MAY_RELEASE


CAME_LATE = (
    "A sensor fault of the tool changer was latched before the start, but the line arbiter read it from its disk "
    f"too late; {RESTARTED}"
)


class ChangerLines(LineWriter, FaultKeeper, Protocol):
    """The methods of the line arbiter that this program calls."""


class ChangerProgram(Program):
    """Executes the automata of the tool changer; the line arbiter stores its sensor fault until a reset (IL-04)."""

    NAME: ClassVar = "tool_change"

    def __init__(
        self,
        description: Description,
        lines: ChangerLines,
        on_status: Listener | None = None,
        recorder: Recorder = NULL_RECORDER,
        clock: Callable[[], int] = now_us,
        judge: FrameJudge | None = None,
        worker: type[SerialWorker | InlineWorker] = SerialWorker,
    ) -> None:
        self._waits = worker is SerialWorker
        self._fault = SensorFault(lines)
        self._look_at: int | None = None  # µs at which the faults of the line arbiter are read again
        super().__init__(description, lines, on_status, recorder, clock, judge, worker)

    def command(self, name: str, until_us: int | None = None) -> Answer:
        """Execute a command; an unlock first waits for its proof (IL-01), unless the program has no thread."""
        if self._waits and name == "unlock" and (changer := self._description.tool_changer):
            await_release(self._latest, changer)
        return super().command(name, until_us)

    def _mapping(self) -> OutputMapping:
        return ChangerOutputs(self._description)

    def _fault_found(self) -> bool:
        return self._fault.found()

    def _keep_faults(self, faults: Mapping[str, str]) -> list[Status]:
        """Keep the latched faults, and schedule a check for a sensor fault that a slow disk has delayed."""
        self._look_at = self._clock()
        return super()._keep_faults(faults)

    def _arbiter_was_lost(self) -> None:
        self._look_at = self._clock() + RETRY_US

    def _due(self) -> int | None:
        looks = [self._look_at] if self._adoption.begun else []
        return min((at for at in (super()._due(), *looks) if at is not None), default=None)

    def _on_time(self, at: int) -> list[Status]:
        if self._look_at is None or at < self._look_at:
            return super()._on_time(at)
        try:
            late = self._fault.came_late()
        except WireError:
            self._look_at = at + RETRY_US
            return super()._on_time(at)
        self._look_at = None
        return self._restart(CAME_LATE) if late else super()._on_time(at)

    def _decide(self, name: str, until_us: int | None = None) -> tuple[Answer, list[Status]]:
        answer, statuses = super()._decide(name, until_us)
        if name == "reset" and answer.accepted:
            self._fault.reset()
        return answer, statuses

    def _restart(self, why: str) -> list[Status]:
        self._fault.restarted()
        return super()._restart(why)

    def _completed(self, status: Status, notices: tuple[Alarm, ...]) -> Status:
        completed, changer = super()._completed(status, notices), self._description.tool_changer
        if changer is None or not self._adoption.lost:
            return completed
        known = self._adoption.outputs.known.get(changer.line, completed.unlock_output)
        return replace(completed, unlock_output=known)

    def _publish_one(self, status: Status) -> None:
        self._fault.update(status)
        super()._publish_one(status)
