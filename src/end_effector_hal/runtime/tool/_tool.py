"""The common interface of a tool, whether its program runs in this process or in another one."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from end_effector_hal._closing import Closing
from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description, did_you_mean
from end_effector_hal.errors import NotReadyError, UsageError
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Alarm, Command, EndEffectorState, distinct
from end_effector_hal.wires import now_us
from end_effector_hal.wires.sensors import SensorHealth

from ._goal_runner import CommandedProgram, GoalRunner, Refused, Result, RunningGoal
from ._listeners import Audience
from ._ready import is_ready, missing
from ._reset import reset_tool, stop


class Tool(Closing):
    """A tool and its commands; all methods are thread-safe.

    `EndEffector` runs the program of the tool in this process. `RemoteTool` talks to one that runs in another process.

    Attributes:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self.description = description
        self._audience = Audience(self._audience_changed)
        self._told: tuple[Alarm, ...] = ()
        self._lock = threading.Lock()
        self._latest: Status | None = None
        self._readings = JudgedReadings(now_us(), {})

    def _follow(self, program: CommandedProgram) -> None:
        """Give all commands to this program; to be called once."""
        self._program = program
        self._goals = GoalRunner(program, lambda: self.status)

    def __repr__(self) -> str:
        state, changer = self.status.ee, self.status.changer
        return f"<{type(self).__name__} {self.description.name}: {state.name}, changer {changer.name}>"

    @property
    def status(self) -> Status:
        """The latest status, with the alarms about its listeners."""
        return self._with_notices(self._program.status)

    @property
    def alive(self) -> bool:
        """Whether the program of the tool works; False too while its process cannot be reached."""
        return self._program.alive

    @property
    @abstractmethod
    def sensors(self) -> SensorHealth:
        """State and counters of the sensor links and inputs; empty if another process reads them."""

    @property
    @abstractmethod
    def outputs(self) -> Mapping[str, bool]:
        """The plain outputs and whether each is active, as the line arbiter reads them back; raises ArbiterError."""

    @abstractmethod
    def ending(self, on: str = "sigterm") -> str:
        """Return what happens to the tool when this object is closed now, in words; empty: nothing."""

    def subscribe(self, listener: Callable[[Status], None], *, name: str = "") -> None:
        """Call the listener with every status, in order, in a thread of its own.

        A listener that raises, or does not return within 2 s, causes an alarm of the tool; it is still called with the
        next status, and the alarm ends when it works again and after a :meth:`reset`. Up to 1,000 statuses wait for a
        slow listener; then the oldest are dropped.
        """
        self._audience.add(Status, listener, name)

    def subscribe_frames(self, listener: Callable[[Frame], None], *, name: str = "") -> None:
        """Call the listener with every frame, in order, in its own thread; the rules of :meth:`subscribe` apply."""
        self._audience.add(Frame, listener, name)

    def subscribe_readings(
        self,
        listener: Callable[[JudgedReadings], None],
        *,
        name: str = "",
        key: Callable[[JudgedReadings], object] | None = None,
    ) -> None:
        """Call the listener with what the sensors read, after each frame and whenever a reading turns stale; the rules
        of :meth:`subscribe` apply. Readings are skipped that have the same ``key`` as those before; it must not wait.
        """
        self._audience.add(JudgedReadings, listener, name, key)
        self.follow_readings()

    def follow_readings(self) -> Callable[[], JudgedReadings]:
        """Return a function for what the sensors read last, which needs no thread and no call for each frame."""
        self._want_readings()
        return lambda: self._readings

    @abstractmethod
    def _want_readings(self) -> None: ...

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
            faults = (alarm.text for alarm in status.alarms if "interlock" in alarm.values)
            return " ".join(faults) if status.ee == EndEffectorState.STAND_BY else ""

        ready = self._program.wait(
            lambda status: bool(latched(status)) or is_ready(self.description, status), timeout_s
        )
        if why := latched(self._program.status):
            raise NotReadyError(
                f"{self.description.name} is not ready: latched: {why}",
                todo="Remove the cause, then `reset` at the prompt, or eehal reset DESCRIPTION.",
            )
        if not ready:
            lacks = missing(self.description, self._program.status, self.sensors)
            raise NotReadyError(
                f"{self.description.name} is not ready after {timeout_s:g} s: {'; '.join(lacks)}.",
                todo="eehal doctor prints what is missing.",
            )

    def begin(self, command: Command, part: str = "") -> Refused | RunningGoal:
        """Begin GRIP, RELEASE, LOCK or UNLOCK; return when it is accepted or refused, before it ends.

        One command runs at a time. Raises UsageError for another command.

        Args:
            command: the command.
            part: name of the part that is to be gripped; empty: the default one.
        """
        return self._goals.begin(command, part)

    def grip(self, part: str = "") -> Result:
        """Grip a part, the default one if it is not named, and wait until the grip has ended."""
        return self.begin(Command.GRIP, part).wait()

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
        return self._program.command("cancel")

    def resume(self) -> Answer:
        """Return from a GRIP_ERROR that a loss caused to GRIPPED, once all evidence is confirmed again and the tool is
        locked (IL-05); nothing is written. For a person's decision only: never call it automatically.
        """
        return self._program.command("resume")

    def stop(self) -> Answer:
        """Latch a stop: nothing is activated until a :meth:`reset`, a running grip is cancelled, what is held stays.

        It is no safety function; see `end_effector_hal.runtime.stop`.
        """
        return stop(self.description)

    def reset(self) -> Answer:
        """Clear latched faults and the alarms that are over; states that need a Drop stay."""
        self._audience.acknowledge()
        self._audience_changed()
        return reset_tool(self.description, self._program)

    def command(self, name: str, part: str = "") -> Answer:
        """Give a command by its channel (`control.goals.CHANNELS`) and return the decision; for a caller that follows
        the statuses from `Answer.count` by itself. ``part``: what is to be gripped.
        """
        answer = self._program.command(name, part)
        return replace(answer, count=answer.count or self._program.status.count)

    def arm(self) -> Answer:
        """Arm an unlock where no sensor shows the tool's stand (IL-02); it expires after 10 s."""
        return self._program.command("arm")

    def set_actuator(self, name: str, active: bool) -> Answer:
        """Drive one actuator in maintenance; raises UsageError for an unknown name."""
        if name not in self.description.actuators:
            raise self._unknown("actuator", name, self.description.sequence)
        return self._program.set_actuator(name, active)

    def set_output(self, name: str, active: bool) -> Answer:
        """Switch a plain output; raises UsageError for an unknown name."""
        if name not in self.description.outputs:
            raise self._unknown("output", name, tuple(self.description.outputs))
        return self._switch(name, active)

    @abstractmethod
    def _switch(self, name: str, active: bool) -> Answer: ...

    def _unknown(self, what: str, name: str, names: Sequence[str]) -> UsageError:
        hint = did_you_mean(name, names)
        known = f"It has {', '.join(names)}." if names else "It has none."
        todo = f"{hint[:1].upper()}{hint[1:]} {known}".lstrip()
        return UsageError(f"{name!r} is no {what} of {self.description.name}.", todo=todo)

    def _with_notices(self, status: Status) -> Status:
        notices = self._audience.alarms
        return replace(status, alarms=distinct((*notices, *status.alarms))) if notices else status

    def _moved(self, status: Status) -> None:
        with self._lock:
            self._latest = status
            self._publish(status)
        self._goals.see(status)

    def _publish(self, status: Status) -> None:
        self._told = self._audience.alarms
        self._audience.put(self._with_notices(status))

    def _audience_changed(self) -> None:
        with self._lock:
            # the last published status: the program may have newer ones, which it publishes in order
            status = self._latest or self._program.status
            self._publish(replace(status, at=now_us(), events=()))

    def _readings_came(self, readings: JudgedReadings) -> None:
        self._readings = readings
        self._audience.put(readings)

    def _frame_came(self, frame: Frame) -> None:
        self._audience.put(frame)
        self._look_at_listeners()

    def _look_at_listeners(self) -> None:
        if self._audience.alarms != self._told:  # a listener that does not return reports nothing itself
            self._audience_changed()
