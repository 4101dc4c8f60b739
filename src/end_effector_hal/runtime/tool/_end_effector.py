"""A whole end-effector in one process, without ROS."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Self

from end_effector_hal._closing import Closing
from end_effector_hal.arbiter import PredicatePublisher
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Answer, Status, ToolEvent, ending_in_words, told_to_grip
from end_effector_hal.control.goals import tool_status
from end_effector_hal.description import Description, did_you_mean
from end_effector_hal.errors import NotReadyError, UsageError
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime.boundary import Observer
from end_effector_hal.runtime.programs import ChangerProgram, GripProgram, Program, open_program
from end_effector_hal.sensing import FrameJudge
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import E_STOPPED, STOPPED, Alarm, ChangerState, Command, EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth
from end_effector_hal.wires.sensors import SensorReader

from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._listeners import Audience
from ._plain_outputs import PlainOutputs
from ._ready import changer_ready, gripper_ready, missing
from ._reset import reset, stop

RESET_S = 5.0
"""Longest wait for a reset of the tool changer, s; longer than the proof of a lock takes, which the reset needs."""
RENEWED_S = 2.0
"""Longest wait until the programs learn that faults are cleared, s; several times the interval between lease renewals,
which carry the latched faults.
"""


class EndEffector(Closing):
    """Both programs of a tool, its sensors and its lines.

    The line arbiter (``eehal arbiter``) is a separate process and must run: it keeps a held part held if this process
    crashes.

    Args:
        description: the tool.
        traces: the folder for the traces of both programs; None: nothing is recorded.
        limits: the recording limits of that folder.
        observe: called with each record of both programs: their inputs, and the steps and decisions of the automata.

    Example:
        >>> with EndEffector.open("end_effector.yaml") as tool:  # doctest: +SKIP
        ...     tool.lock()
        ...     result = tool.grip()
        ...     tool.drop()
    """

    def __init__(
        self,
        description: Description,
        *,
        traces: str | Path | None = None,
        limits: RecordingLimits | None = None,
        observe: Observer | None = None,
    ) -> None:
        self.description = description
        self._audience = Audience(self._audience_changed)
        self._told: tuple[Alarm, ...] = ()
        self._gripping: Status | None = None
        self._lock = threading.Lock()
        judge = FrameJudge()
        with ExitStack() as undo:
            open_one = partial(open_program, traces=traces, limits=limits, judge=judge, observe=observe)
            self._grip = open_one(GripProgram, description, self._gripper_moved)
            undo.callback(self._grip.close)
            self._change = open_one(ChangerProgram, description, self._changer_moved)
            undo.callback(self._change.close)
            self._outputs = PlainOutputs(description)
            undo.callback(self._outputs.close)
            self._goals = GoalRunner({"grip": self._grip, "tool_change": self._change}, lambda: self.status)
            self._predicates = PredicatePublisher(description, judge=judge)
            self._reader = SensorReader(description, self._frame_came, self._link_changed)
            undo.pop_all()

    @classmethod
    def open(
        cls,
        description: Description | str | Path,
        *,
        traces: str | Path | None = None,
        limits: RecordingLimits | None = None,
    ) -> Self:
        """Open a tool by its description and adopt its lines; raises DescriptionError, WireError."""
        loaded = description if isinstance(description, Description) else load_tool(description)
        tool = cls(loaded, traces=traces, limits=limits)
        try:
            tool.start()
        except BaseException:
            tool.close()
            raise
        return tool

    def start(self) -> None:
        """Start to read the sensors and adopt the lines; raises LinkBusyError or LineBusyError if another process
        does.
        """
        self._reader.start()
        self._predicates.start()
        for unit in self._units:
            unit.start()

    def close(self, ending: str = "sigterm") -> None:
        """End: the line arbiter does what the description declares. Listeners get the waiting items, within 2 s.

        A running command ends UNREACHABLE; its reason contains what happens to the outputs.
        """
        self._goals.close(ending_in_words(self.description, self.status, on=ending))
        for unit in self._units:
            unit.close(ending)
        self._outputs.close()
        self._reader.close()
        self._predicates.close()
        self._audience.close()

    def __repr__(self) -> str:
        state, changer = self.status.ee, self.status.changer
        return f"<EndEffector {self.description.name}: {state.name}, changer {changer.name}>"

    @property
    def status(self) -> Status:
        """The gripping program and the tool changer in one snapshot."""
        grip, change = self._grip.status, self._change.status
        return self._merged(grip, max(grip.at, change.at))

    @property
    def link(self) -> LinkHealth | None:
        """State and counters of the sensor link, the first if there are several; None: the tool has none."""
        return next(iter(self.links.values()), None)

    @property
    def links(self) -> Mapping[str, LinkHealth]:
        """State and counters of each sensor link, by its name; a single link without a name has an empty one."""
        return self._reader.health.links

    @property
    def inputs(self) -> InputsHealth | None:
        """State and counters of the inputs of the board; None: no channel uses one."""
        return self._reader.health.inputs

    def subscribe(self, listener: Callable[[Status], None], *, name: str = "") -> None:
        """Call the listener with every status, in order, in a thread of its own.

        A listener that raises, or does not return within 2 s, causes an alarm of the tool; it is still called with the
        next status, and the alarm ends when it works again and after a :meth:`reset`. Up to 1,000 statuses wait for a
        slow listener; then the oldest are dropped.
        """
        self._audience.add(listener, name)

    def subscribe_frames(self, listener: Callable[[Frame], None], *, name: str = "") -> None:
        """Call the listener with every frame, in order, in its own thread; the rules of :meth:`subscribe` apply."""
        self._audience.add_for_frames(listener, name)

    def wait_ready(self, timeout_s: float = 5.0) -> None:
        """Wait until the tool has adopted its lines, and its sensors give no reason to refuse a command.

        In STAND_BY every actuator is then proven to be gone, so that IL-07 does not refuse a grip; in other states the
        evidence of every actuator is known. The lock of the tool changer (IL-05) and the supply (IL-06) are not waited
        for.

        Raises:
            NotReadyError: the time is over, or the line arbiter has latched a fault that makes it refuse a grip in
                STAND_BY (IL-13, a sensor fault); the error says what is missing. The tool keeps running: commands that
                its sensors do not support are refused with a reason, and held parts stay held.
        """

        def latched(status: Status) -> str:
            return " ".join(self._grip.latched_interlocks) if status.ee == EndEffectorState.STAND_BY else ""

        until = now_us() + round(timeout_s * 1e6)
        ready = self._grip.wait(
            lambda status: bool(latched(status)) or gripper_ready(self.description, status), timeout_s
        )
        if why := latched(self._grip.status):
            raise NotReadyError(
                f"{self.description.name} is not ready: latched: {why}",
                todo="Remove the cause, then `reset` at the prompt, or eehal reset DESCRIPTION.",
            )
        ready = ready and self._change.wait(
            lambda status: changer_ready(self.description, status), max(0.0, (until - now_us()) / 1e6)
        )
        if not ready:
            lacks = missing(self.description, self._grip.status, self._change.status, self._reader.health)
            raise NotReadyError(
                f"{self.description.name} is not ready after {timeout_s:g} s: {'; '.join(lacks)}.",
                todo="eehal doctor prints what is missing.",
            )

    def begin(self, command: Command) -> Refused | RunningGoal:
        """Begin GRIP, RELEASE, LOCK or UNLOCK; return when it is accepted or refused, before it ends.

        One command runs at a time. Raises UsageError for another command.
        """
        return self._goals.begin(command)

    def grip(self) -> Result:
        """Grip, and wait until the grip has ended."""
        return self.begin(Command.GRIP).wait()

    def drop(self) -> Result:
        """Release the held part, and wait until the release is proven."""
        return self.begin(Command.RELEASE).wait()

    def lock(self) -> Result:
        """Lock the tool changer, and wait for the proof."""
        return self.begin(Command.LOCK).wait()

    def unlock(self) -> Result:
        """Unlock the tool changer, and wait for the proof."""
        return self.begin(Command.UNLOCK).wait()

    def cancel(self) -> Answer:
        """Cancel a running grip; return when the cancel is accepted or refused."""
        return self._grip.command("cancel")

    def stand_still(self) -> Answer:
        """Block activations for 30 s if the tool is at rest now: for a caller that will load another description.

        `runtime.reload_answer` returns whether the file can be adopted; then close this tool and open it again, or
        call `go_on`.
        """
        answers = [unit.stand_still() for unit in self._units]
        refused = next((answer for answer in answers if not answer.accepted), None)
        if refused is not None:
            self.go_on()
        return refused or answers[0]

    def go_on(self) -> None:
        """End the block of a `stand_still`."""
        for unit in self._units:
            unit.stand_still(0)

    def stop(self) -> Answer:
        """Latch a stop: nothing is activated until a :meth:`reset`, a running grip is cancelled, what is held stays.

        It is no safety function; see `end_effector_hal.runtime.stop`.
        """
        return stop(self.description)

    def reset(self) -> Answer:
        """Clear latched faults and the alarms that are over; states that need a Drop stay."""
        self._audience.acknowledge()
        self._audience_changed()
        answers = []
        if self._change.status.changer_fault:
            changer = self._change.command("reset")
            self._change.wait(lambda status: status.changer != ChangerState.LOCKING, RESET_S)
            status = self._change.status
            answers.append(Answer(not status.changer_fault, status.reason) if changer.accepted else changer)
        answer = reset(self.description, self._grip, *answers)
        if answer.accepted:
            # the line arbiter tells the programs with their next renewal: until then they would refuse a grip
            for unit in self._units:
                unit.wait(lambda status: not status.alarm(STOPPED, E_STOPPED), RENEWED_S)
        return answer

    def arm(self) -> Answer:
        """Arm an unlock where no sensor shows the tool's stand (IL-02); it expires after 10 s."""
        return self._change.command("arm")

    def set_actuator(self, name: str, active: bool) -> Answer:
        """Drive one actuator in maintenance; raises UsageError for an unknown name."""
        if name not in self.description.actuators:
            raise self._unknown("actuator", name, self.description.sequence)
        return self._grip.set_actuator(name, active)

    def set_output(self, name: str, active: bool) -> Answer:
        """Switch a plain output; raises UsageError for an unknown name."""
        if name not in self.description.outputs:
            raise self._unknown("output", name, tuple(self.description.outputs))
        return self._outputs.set(name, active)

    @property
    def outputs(self) -> Mapping[str, bool]:
        """The plain outputs and whether each is active, as the line arbiter reads them back; raises ArbiterError."""
        return self._outputs.levels

    def _unknown(self, what: str, name: str, names: Sequence[str]) -> UsageError:
        hint = did_you_mean(name, names)
        known = f"It has {', '.join(names)}." if names else "It has none."
        todo = f"{hint[:1].upper()}{hint[1:]} {known}".lstrip()
        return UsageError(f"{name!r} is no {what} of {self.description.name}.", todo=todo)

    @property
    def _units(self) -> tuple[Program, Program]:
        return self._grip, self._change

    def _merged(self, grip: Status, at: int, events: tuple[ToolEvent, ...] = ()) -> Status:
        return tool_status(grip, self._change.status, at, notices=self._audience.alarms, events=events)

    def _gripper_moved(self, status: Status) -> None:
        self._change.update_peer(ee=status.ee)
        with self._lock:
            self._gripping = status
            self._publish(self._merged(status, status.at, status.events))

    def _changer_moved(self, status: Status) -> None:
        self._grip.update_peer(**told_to_grip(status))
        with self._lock:
            # the one that was told last: the program may be further, and tells what lies between in its order
            grip = self._gripping or self._grip.status
            # not as of a time before its own: this one may have waited while the gripping went on
            self._publish(self._merged(grip, max(grip.at, status.at), status.events))

    def _publish(self, status: Status) -> None:
        self._told = self._audience.alarms
        self._audience.status(status)

    def _audience_changed(self) -> None:
        with self._lock:
            self._publish(self._merged(self._gripping or self._grip.status, now_us()))

    def _frame_came(self, frame: Frame) -> None:
        self._predicates.frame(frame, self._pass_on)

    def _link_changed(self, _source: str, _health: object) -> None:
        links = self.links.items()
        texts = [(name and f"Link {name}: ") + each for name, link in links for each in link.faults]
        # a decoder gives its faults no other identity than their sentences
        faults = tuple([Alarm("link.fault", text, {"text": text}) for text in texts])
        for unit in self._units:
            unit.see_link_faults(faults)

    def _pass_on(self, frame: Frame) -> None:
        for unit in self._units:
            unit.frame(frame)
        self._audience.frame(frame)
        if self._audience.alarms != self._told:  # a listener that does not return says nothing by itself
            self._audience_changed()
