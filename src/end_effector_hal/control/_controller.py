"""One program of a tool: its automata with its detectors. Events and time in, statuses and a deadline out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from end_effector_hal.automata import Event, Execution, Network, Observation, Step
from end_effector_hal.description import Description
from end_effector_hal.trace import Command, EndEffectorState
from end_effector_hal.wires.codecs import codec_of
from end_effector_hal.wires.frame import Frame

from ._changer_reasons import explain_changer
from ._hold_monitor import HoldMonitor
from ._levels import Cause, ChangerState, Evidence, ToolEvidence
from ._predicates import LOCKED, predicates_fitted
from ._reasons import explain, latched, left_active, not_by_hand, refusal
from ._senses import Senses
from ._status import Answer, Status
from ._steps import StepLog

FIRST_FRAME_US = 5_000_000
"""What was found active waits so long for the link before it counts as unproven: who reads it may start later."""
CHANGER_FAULT = "The tool changer is in FAULT: its sensors do not prove where it is. Remedy it, then Lock."
PROGRAMS = ("grip", "tool_change")
_SCALARS = (
    "ee", "command", "cause", "cause_at", "changer", "changer_command", "changer_fault", "unlock_valve", "armed",
)  # fmt: skip
_AT_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)


class Controller:
    """Executes the automata of one program; sans-IO: the same object runs in real and in virtual time.

    Time is an argument everywhere: µs on the monotonic clock, never running backwards.

    Args:
        description: the tool.
        network: its automata with its constants put in.
        program: ``grip`` or ``tool_change``: which of the executed processes this is.
        observe: is told of what the automata see and do.
    """

    def __init__(
        self,
        description: Description,
        network: Network,
        program: str,
        observe: Callable[[Observation], None] | None = None,
    ) -> None:
        self._description = description
        self._program, self._grips = program, program == "grip"
        codec = codec_of(description)
        self._senses = Senses(description, codec)
        self._lock_fitted = LOCKED in predicates_fitted(description, codec)
        self._hold = HoldMonitor(description, self._senses, codec.period_us)
        processes = getattr(description.automata, program)
        interface = description.automata.interface
        self._execution = Execution(network, processes, interface, observe=observe)
        self._steps = StepLog(description.sequence)
        self._values = {name: self._execution.value(name) for name in _watched(len(description.sequence))}
        self._cause, self._cause_at, self._reason, self._left = int(Cause.NONE), -1, "", ""
        self._levels: Mapping[str, bool] = {}
        self._sensor_fault = False
        self._adopt_by: int | None = None
        self._adopted = False
        self._missed, self._worst_late_us = 0, 0
        self._at = 0

    @property
    def deadline(self) -> int | None:
        """µs of the next thing that happens by itself, or None."""
        due = (self._execution.deadline, self._senses.deadline(self._at), self._adopt_by)
        return min((time for time in due if time is not None), default=None)

    def start(self, levels: Mapping[str, bool], at: int, *, sensor_fault: bool = False) -> list[Status]:
        """Begin, with the lines' levels as they were found; adoption follows once the sensors are read.

        ``sensor_fault``: one of the tool changer's sensors was latched before (IL-04); only a reset clears it.
        """
        self._at, self._levels, self._sensor_fault = at, levels, sensor_fault
        down_us = self._senses.readings.down_us
        self._adopt_by = at + (max(FIRST_FRAME_US, down_us) if any(levels.values()) else down_us)
        return self._told(self._execution.start(at))

    def frame(self, frame: Frame, at: int | None = None) -> list[Status]:
        """One frame of the link, which came at ``frame.at`` and is taken now, at ``at``.

        When it came decides whether it is before a time-out; when it is taken is when the next wait begins, so that
        no line is active for less than its time. One that waited until it was stale proves nothing any more.
        """
        if at is not None and at - frame.at >= self._senses.readings.stale_us:
            return self.advance(at)
        expired = self._senses.deadline(self._at)
        self._at = max(self._at, frame.at, at or 0)
        statuses: list[Status] = []
        if expired is not None and expired < frame.at:
            events = self._senses.advance(expired)
            self._execution.write(self._senses.levels)
            self._hold.sample(expired, held=self._held)
            for event in events:
                statuses += self._receive(event, self._at, expired)
        if self._adopt_by is not None:
            self._adopt_by = min(self._adopt_by, self._at + self._senses.readings.down_us)
        vented = self._senses.vented
        events = self._senses.frame(frame)
        self._execution.write(self._senses.levels)
        told = self._hold.sample(frame.at, held=self._held) | self._senses.noticed(frame.at, held=self._held)
        for event in events:
            statuses += self._receive(event, self._at, frame.at)
        if not self._adopted and self._senses.settled:
            statuses += self._adopt(self._at)
        told |= self._senses.vented is not vented
        return statuses if statuses or not (events or told) else [self.status()]

    def tell(self, values: Mapping[str, int], at: int) -> list[Status]:
        """What another program says: ``ee`` or ``unlock_valve``, as the model has them."""
        at = self._until(at)
        statuses = self._due_before(at)
        if "ee" in values:
            self._execution.write({"told[0]": int(values["ee"] in _AT_REST)})
        if "unlock_valve" in values:
            self._execution.write({"told[1]": values["unlock_valve"]})
        self._values.update(values)
        return statuses + self._told(self._execution.advance(at))

    def command(self, name: str, at: int) -> tuple[Answer, list[Status]]:
        """A command by the name of its channel; whether it is accepted is an edge of the automaton."""
        at = self._until(at)
        statuses = self._due_before(at)
        reaction = self._execution.receive(Event(name), at)
        if not reaction.taken:
            why = refusal(self._description, name, self.status(), self._senses, at)
            return Answer(False, why), statuses + self._told(reaction.steps)
        if name in ("grip", "drop"):
            self._take_cause(Cause.NONE, -1)
            self._hold.dropped()
        return Answer(True), statuses + self._told(reaction.steps)

    def refused(self, at: int) -> list[Status]:
        """The line owner refused to activate what the last status asked for."""
        at = self._until(at)
        statuses = self._due_before(at)
        channel = "unlock_refused" if self._program == "tool_change" else "grip_refused"
        return statuses + self._receive(Event(channel), at)

    def acknowledge(self, at: int) -> list[Status]:
        """Alarms that are over were seen: they are forgotten. Nothing else is changed by it."""
        at = self._until(at)
        statuses = self._due_before(at)
        self._hold.acknowledge()
        return [*statuses, self.status()]

    @property
    def _latched_error(self) -> str:
        """An error that no reset clears, in words; empty: there is none."""
        return latched(EndEffectorState(self._values["ee"]), self._why) if self._latched else ""

    @property
    def _why(self) -> str:
        return " ".join(filter(None, (self._reason, self._left)))

    def refuse_maintenance(self, *, active: bool) -> str:
        """Why the line of an actuator may not be driven by hand now (IL-12); empty: it may."""
        if refused := not_by_hand(EndEffectorState(self._values["ee"]), held=self._held):
            return refused
        needs_lock = active and self._description.interlocks.il_05 and self._lock_fitted
        if needs_lock and self._senses.tool is not ToolEvidence.LOCKED:
            return f"IL-05: the tool is not proven to be locked (its sensors say {self._senses.tool.name})."
        if active and self._description.interlocks.il_05 and self._values["unlock_valve"]:
            return "IL-05: the unlock output is active."
        return ""

    def advance(self, at: int) -> list[Status]:
        """Everything that is due at or before ``at``."""
        at = self._until(at)
        statuses: list[Status] = []
        while (due := self.deadline) is not None and due <= at:
            # what is late is taken now, and told as late: nobody may see a time at which nothing happened
            self._at = at
            events = self._senses.advance(at)
            self._execution.write(self._senses.levels)
            self._hold.sample(at, held=self._held)
            for event in events:
                statuses += self._receive(event, at)
            if self._adopt_by is not None and at >= self._adopt_by:
                statuses += self._adopt(at)
            statuses += self._told(self._execution.advance(at)) or [self.status()]
        self._at = at
        return statuses

    def status(self) -> Status:
        """The state as it is now."""
        values, outputs = self._values, self._levels_now
        ee = values["ee"]
        command = values["changer_command" if self._program == "tool_change" else "command"]
        evidence = tuple(int(level) for level in self._senses.evidence)
        proven = ee == EndEffectorState.GRIPPED and all(level == Evidence.CONFIRMED for level in evidence)
        step = self._steps.step
        readings = self._senses.readings
        return Status(
            at=self._at,
            ee=ee,
            command=command,
            actuators=self._actuators,
            outputs=outputs,
            evidence=evidence,
            step=step,
            attempt=self._steps.steps[step].attempts if step >= 0 else 0,
            attempts_allowed=self._description.ordered[step][1].attempts if step >= 0 else 0,
            deadline=self._execution.deadline,
            cause=self._cause,
            cause_at=self._cause_at,
            reason=self._why or explain_changer(self._description, values["changer_fault"]),
            lift_allowed=proven and self._hold.allows_lift,
            held=self._held,
            kept=tuple(i for i in range(len(outputs)) if values[f"kept[{i}]"]),
            secure=proven and self._hold.secure,
            changer=values["changer"],
            unlock_output=bool(values["unlock_valve"]),
            changer_fault=values["changer_fault"],
            vented=self._senses.vented,
            armed=bool(values["armed"]),
            link_up=readings.link_up(self._at),
            stale=readings.stale(self._at),
            missed=self._missed,
            worst_late_us=self._worst_late_us,
            alarms=self._alarms(),
            steps=self._steps.steps,
        )

    def _alarms(self) -> tuple[str, ...]:
        alarms = []
        link, supply = self._description.link, self._senses.supply
        if self._adopted and not self._senses.readings.link_up(self._at):
            alarms.append(f"The sensor link {link.port} is down.")
        if self._latched:
            alarms.append(self._latched_error)
        if self._program == "tool_change" and self._values["changer"] == ChangerState.FAULT:
            alarms.append(CHANGER_FAULT)
        alarms += self._hold.alarms
        if self._adopted:
            alarms += self._senses.notices(self._at, held=self._held)
        if supply.low and self._grips and not self._held:
            alarms.append(f"Low supply: under {self._description.supply.warn_kpa:g} kPa.")
        return tuple(alarms)

    def _until(self, at: int) -> int:
        # what arrives late, with an older stamp, counts as arriving now
        return max(at, self._at)

    def _due_before(self, at: int) -> list[Status]:
        # inputs stamped at or before a deadline go before that time-out
        statuses = self.advance(at - 1)
        self._at = at
        return statuses

    def _receive(self, event: Event, at: int, stamp: int | None = None) -> list[Status]:
        if event.channel not in self._execution.inputs:  # nobody waits for it: it is a level only
            return self._told(self._execution.write(event.writes, at))
        return self._told(self._execution.receive(event, at, stamp=stamp).steps)

    def _adopt(self, at: int) -> list[Status]:
        self._adopted, self._adopt_by = True, None
        parts = [part for _, part in self._description.ordered]
        adopted = {f"adopted[{i}]": int(self._levels.get(part.line, False)) for i, part in enumerate(parts)}
        changer = self._description.tool_changer
        if changer is not None:
            adopted["adopted_unlock"] = int(self._levels.get(changer.line, False))
            adopted["adopted_fault"] = int(self._sensor_fault)
        self._execution.write(adopted)  # before the event: whoever receives it asks for these levels
        return self._receive(Event("adopt"), at)

    def _told(self, steps: Iterable[Step]) -> list[Status]:
        statuses = []
        for step in steps:
            self._missed += step.missed
            self._worst_late_us = max(self._worst_late_us, step.late_us)
            self._at = max(self._at, step.at)
            self._values.update((change.name, change.new) for change in step.changes)
            if self._values["cause"]:
                self._take_cause(self._values["cause"], self._values["cause_at"])
            again = step.sent is not None and step.sent.startswith("again[")
            self._steps.take(self._values["ee"], self._outputs, self._actuators, step.at, again=again)
            statuses.append(self.status())
        return statuses

    def _take_cause(self, cause: int, at: int) -> None:
        if cause == Cause.KEPT:  # what it ended for is told already
            self._left = self._left or left_active(self._description, self._outputs)
        elif (cause, at) != (self._cause, self._cause_at):
            # in the words of this moment: the reading that decided it is soon another one
            self._reason = explain(self._description, cause, at, self._senses, self._at)
            self._cause, self._cause_at, self._left = cause, at, ""

    @property
    def _latched(self) -> bool:
        error = self._values["ee"] in (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)
        return self._grips and error and self._values["command"] == Command.NONE

    @property
    def _held(self) -> bool:
        # what was found active is held until it is adopted and known better
        doubtful = not self._adopted or (self._latched and self._values["ee"] == EndEffectorState.GRIP_ERROR)
        held = self._values["ee"] == EndEffectorState.GRIPPED or (doubtful and any(self._levels_now))
        return self._grips and held

    @property
    def _levels_now(self) -> tuple[bool, ...]:
        return self._outputs if self._adopted else self._found

    @property
    def _outputs(self) -> tuple[bool, ...]:
        return tuple(bool(self._values[f"valve[{i}]"]) for i in range(len(self._description.sequence)))

    @property
    def _found(self) -> tuple[bool, ...]:
        return tuple(self._levels.get(part.line, False) for _, part in self._description.ordered)

    @property
    def _actuators(self) -> tuple[int, ...]:
        return tuple(self._values[f"actuator[{i}]"] for i in range(len(self._description.sequence)))


def _watched(size: int) -> list[str]:
    return [*_SCALARS, *(f"{name}[{i}]" for name in ("valve", "actuator", "kept") for i in range(size))]
