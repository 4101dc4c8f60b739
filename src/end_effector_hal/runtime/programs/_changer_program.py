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
"""What a vacuum that has just been told gone takes to fall below what IL-01 asks for, at the longest."""
LAG_S = 0.15
"""What shows the end of a release may be under way to this program for so long."""
_MAY_RELEASE = (EndEffectorState.STAND_BY, EndEffectorState.OFF, EndEffectorState.RELEASING)


def await_release(latest: LatestStatus, changer: ToolChanger) -> None:
    """Wait until the release is proven or cannot be, for no longer than the fall and the proof take.

    Feedback that is still there says nothing: the last frame of the release may not have come to this program yet.
    """
    latest.wait(release_is_decided, longest_release_s(changer))


def longest_release_s(changer: ToolChanger) -> float:
    """Seconds that an unlock waits at the longest."""
    return LAG_S + FALL_S + changer.vented_s


def release_is_decided(status: Status) -> bool:
    """Whether the release is proven, or cannot be."""
    return status.vented or status.ee not in _MAY_RELEASE


CAME_LATE = (
    "A sensor fault of the tool changer was latched before the start, and the disk of the line arbiter has given it "
    f"back late; {RESTARTED}"
)


class ChangerLines(LineWriter, FaultKeeper, Protocol):
    """What this program needs of the line arbiter."""


class ChangerProgram(Program):
    """Executes the automata of the tool changer; the line arbiter keeps its sensor fault until a reset (IL-04)."""

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
        """Like every program's; an unlock first waits for its proof, where there is a thread that can wait."""
        if self._waits and name == "unlock" and (changer := self._description.tool_changer):
            await_release(self._latest, changer)
        return super().command(name, until_us)

    def _mapping(self) -> OutputMapping:
        return ChangerOutputs(self._description)

    def _fault_found(self) -> bool:
        return self._fault.found()

    def _keep_faults(self, faults: Mapping[str, str]) -> list[Status]:
        """A sensor fault may be among them that a slow disk has kept back until now."""
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
