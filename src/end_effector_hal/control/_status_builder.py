"""Builds the status of a tool after each step of its automata."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from end_effector_hal.description import Description, used_channels
from end_effector_hal.sensing import HoldMonitor, SensorSet
from end_effector_hal.signals import NESTED, clone
from end_effector_hal.vocabulary import (
    LATCHED_ERRORS,
    Alarm,
    Cause,
    ChangerFault,
    ChangerState,
    Command,
    EndEffectorState,
    ToolEvidence,
    display_name,
)
from timed_automata import Execution, Network, Step
from timed_automata.document import Text
from timed_automata.language import parse_expression
from timed_automata.queries import compile_integer

from ._events import EventReader, ToolEvent
from ._status import Status
from ._steps import StepLog
from .words import explain, explain_changer, left_active, loose

# a lookup costs less than a conversion, and there is one for each status
_STATES = {int(each): each for each in EndEffectorState}
_COMMANDS = {int(each): each for each in Command}
_CAUSES = {int(each): each for each in Cause}
_CHANGER_STATES = {int(each): each for each in ChangerState}
_CHANGER_FAULTS = {int(each): each for each in ChangerFault}
_SCALARS = (
    "ee", "command", "cause", "cause_at", "changer", "changer_command", "changer_fault", "unlock_valve", "armed",
    "dropped", "part",
)  # fmt: skip


_OF_CHANGER = ("Changer", "Arming")
"""Templates whose deadlines concern no grip and no release."""
Condition = Callable[[tuple[int, ...], tuple[int, ...]], Any]


class StatusBuilder:
    """Collects the state of the automata, the detectors and the hold monitor in a status; makes no decisions.

    Attributes:
        values: variables of the automata, by name.
        found: levels of the lines as they were found at the start.
        was_error: whether GRIP_ERROR was latched before the start.
        part_recorded: whether it was recorded at the start which part is held.
        adopted: whether the automata have received these levels.
        held: whether a part is held; outputs found active count as holding until they are adopted and judged.
    """

    MEMORY: ClassVar = {
        "values": dict[str, int],
        "found": dict[str, bool],
        "was_error": bool,
        "part_recorded": bool,
        "adopted": bool,
        "held": bool,
        "_noticed": tuple[Alarm, ...],
        "_steps": NESTED,
        "_events": NESTED,
        "_cause": int,
        "_cause_at": int,
        "_reason": str,
        "_left": str,
        "_missed": int,
        "_worst_late_us": int,
        "_outputs": tuple[bool, ...],
        "_actuators": tuple[int, ...],
        "_active": tuple[bool, ...],
        "_latched": bool,
    }

    def __init__(
        self,
        description: Description,
        execution: Execution,
        senses: SensorSet,
        hold: HoldMonitor,
    ) -> None:
        self._description, self._execution = description, execution
        self._senses, self._hold = senses, hold
        size = range(len(description.sequence))
        self._valves, self._states = [f"valve[{i}]" for i in size], [f"actuator[{i}]" for i in size]
        self._keeps = [f"kept[{i}]" for i in size]
        blown = map(description.sequence.index, description.blow_offs)
        self._blows = [(i, f"blow[{i}]") for i in blown]
        blows = [name for _, name in self._blows]
        self._per_actuator, self._of_a_release = {*self._valves, *self._states}, {*self._keeps, *blows}
        self._lines = [actuator.line for _, actuator in description.ordered]
        self._unread = description.may_be_unknown  # nobody may know how they stand: in doubt active
        self._used = used_channels(description)
        self._fastened = _condition(execution.network, "fastened")
        self._liftable = _condition(execution.network, "liftable")
        self._of_changer = frozenset(
            each.index for each in execution.network.processes if each.template in _OF_CHANGER
        )
        self._tools, self._names = description.per_part, description.part_names
        self._named = bool(description.parts)
        self._allowed = [[actuator.attempts for _, actuator in tool.ordered] for tool in self._tools]
        self.values = {
            name: execution.value(name)
            for name in (*_SCALARS, *self._valves, *self._states, *self._keeps, *blows)
        }
        self.found: Mapping[str, bool] = {}
        self.was_error = False
        self.part_recorded = True
        self.adopted = False
        self.held = False
        self._steps, self._events = StepLog(description.sequence), EventReader()
        self._cause, self._cause_at, self._reason, self._left = int(Cause.NONE), -1, "", ""
        self._missed, self._worst_late_us = 0, 0
        self._outputs: tuple[bool, ...] = ()
        self._actuators: tuple[int, ...] = ()
        self._kept: tuple[int, ...] = ()
        self._blowing: tuple[int, ...] = ()
        self._seen: tuple[int, int, bool] | None = None
        self._noticed: tuple[Alarm, ...] = ()
        self.know({})

    @property
    def outputs(self) -> tuple[bool, ...]:
        """Whether each actuator is commanded to be active, in sequence order."""
        return self._outputs

    def know(self, values: Mapping[str, int]) -> None:
        """Update variables of the automata; with no values, update all that depends on the adoption."""
        known = self.values
        known.update(values)
        if not values or not self._per_actuator.isdisjoint(values):
            self._outputs = tuple(map(bool, map(known.__getitem__, self._valves)))
            self._actuators = tuple(map(known.__getitem__, self._states))
        if not values or not self._of_a_release.isdisjoint(values):
            self._kept = tuple([i for i, name in enumerate(self._keeps) if known[name]])
            self._blowing = tuple([i for i, name in self._blows if known[name]])
        if not values or "changer_fault" in values:
            self._changer_fault = explain_changer(self._description, known["changer_fault"])
        self._active = (
            self._outputs
            if self.adopted
            else tuple([bool(self.found.get(n, n in self._unread)) for n in self._lines])
        )
        ee = known["ee"]
        errors = EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR
        self._latched = ee in errors and known["command"] == Command.NONE
        doubtful = not self.adopted or (self._latched and ee == EndEffectorState.GRIP_ERROR)
        self.held = ee == EndEffectorState.GRIPPED or (doubtful and any(self._active))

    def step(self, step: Step, at: int) -> Status:
        """Return the status after one more step, at ``at`` µs."""
        self._missed += step.missed
        self._worst_late_us = max(self._worst_late_us, step.late_us)
        changes = {}
        for change in step.changes:
            changes[change.name] = change.new
        self.know(changes)
        if self.values["cause"]:
            self.blame(self.values["cause"], self.values["cause_at"], at)
        elif self.values["ee"] == EndEffectorState.GRIPPED:  # a resume ends the loss
            self.blame(Cause.NONE, -1, at)
        events = self._events.of(step, at)
        self._steps.take(events, step.at, gripping=self.values["ee"] == EndEffectorState.GRIPPING)
        return self.status(at, events)

    def ahead(self, execution: Execution) -> StatusBuilder:
        """Return a copy that builds the statuses of a copy of the execution; for what is only foreseen."""
        new = clone(self)
        new._execution = execution
        return new

    def blame(self, cause: int, cause_at: int, at: int) -> None:
        """Store why a grip or a release ended, with the readings of this moment, which soon change."""
        if cause == Cause.KEPT:  # what it ended for is told already
            self._left = self._left or left_active(self._description, self._outputs)
        elif (cause, cause_at) != (self._cause, self._cause_at):
            self._reason = self._before(cause) or explain(self._tool, cause, cause_at, self._senses.now, at)
            self._cause, self._cause_at, self._left = cause, cause_at, ""

    def _before(self, cause: int) -> str:
        """Return a sentence if a former error or an output's unknown state is the cause; empty: neither is."""
        if cause == Cause.UNPROVEN_AT_START and self.was_error:
            return "GRIP_ERROR was latched before the program restarted."
        ordered = self._description.ordered
        names = [
            display_name(name)
            for name, actuator in ordered
            if actuator.line in self._unread and actuator.line not in self.found
        ]
        if cause != Cause.UNPROVEN_AT_START or not names:
            return ""
        return (
            f"At the start nothing was known of the output of {', '.join(names)}, and the sensors prove neither a grip "
            "nor a release: in doubt it counts as active. Whether a part is held is not known."
        )

    @property
    def _tool(self) -> Description:
        """The tool as it grips the present part."""
        return self._tools[self.values["part"]]

    @property
    def steps(self) -> StepLog:
        """Attempts and times of the steps."""
        return self._steps

    def status(self, at: int, events: tuple[ToolEvent, ...] = ()) -> Status:
        """Return the status at ``at`` µs; ``events``: the events that led to it."""
        values, hold, steps = self.values, self._hold, self._steps
        ee = _STATES[values["ee"]]
        if self._seen != (at, self._senses.revision, self.held):
            self._look(at)
        proven = ee == EndEffectorState.GRIPPED and self._senses.now.confirmed and self._is(self._liftable)
        step = steps.step
        gripping, deadline = values["command"], self._execution.deadline
        if gripping == Command.NONE:
            deadline = None
        elif values["armed"] or values["unlock_valve"] or values["changer"] == ChangerState.LOCKING:
            deadline = self._execution.deadline_without(self._of_changer)
        return Status(
            at=at,
            ee=ee,
            command=_COMMANDS[values["changer_command"] if gripping == Command.NONE else gripping],
            actuators=self._actuators,
            outputs=self._active,
            evidence=self._senses.now.evidence,
            step=step,
            attempt=steps.steps[step].attempts if step >= 0 else 0,
            attempts_allowed=self._allowed[values["part"]][step] if step >= 0 else 0,
            deadline=deadline,
            cause=_CAUSES[self._cause],
            cause_at=self._cause_at,
            reason=self._why if self._left else self._reason,
            lift_allowed=proven and hold.allows_lift,
            held=self.held,
            part=self._part if self._named else "",
            kept=self._kept,
            blowing=self._blowing,
            dropped=values["dropped"],
            secure=proven and hold.secure,
            adopted=self.adopted,
            changer=_CHANGER_STATES[values["changer"]],
            unlock_output=bool(values["unlock_valve"]),
            changer_fault=_CHANGER_FAULTS[values["changer_fault"]],
            changer_reason=self._changer_fault or self._vacant,
            vented=self._senses.now.nothing_gripped,
            armed=bool(values["armed"]),
            link_up=not self._down,
            stale=self._stale,
            missed=self._missed,
            worst_late_us=self._worst_late_us,
            refused_frames=self._refused,
            alarms=self._alarms(),
            steps=steps.steps,
            events=events,
        )

    @property
    def _part(self) -> str:
        """Name of the part that is gripped, held or released; empty: none."""
        at_rest = self.values["ee"] in (EndEffectorState.OFF, EndEffectorState.STAND_BY)
        unproven = self._cause == Cause.UNPROVEN_AT_START and self.values["ee"] == EndEffectorState.GRIP_ERROR
        return "" if at_rest or (unproven and not self.part_recorded) else self._names[self.values["part"]]

    def noticed(self, at: int) -> bool:
        """Return whether the alarms about the readings have changed since the last call."""
        self._look(at)
        before, self._noticed = self._noticed, self._notices
        return self._noticed != before

    def _look(self, at: int) -> None:
        """Read the sensors' state once for all steps that follow from it."""
        senses, readings = self._senses, self._senses.now.readings
        self._seen = at, senses.revision, self.held
        self._refused = senses.stamps.refused
        changer, absent = self._description.tool_changer, senses.now.tool is ToolEvidence.ABSENT
        self._vacant = f"There is no tool ({changer.present_bit} is off)." if changer and absent else ""
        self._down = readings.down(at)
        links = dict.fromkeys([source.link for source in self._down]) if self._down else ()
        self._outages = [
            Alarm("link.down", link or "", {"sensors": self._description.sensors_are("down", link)})
            for link in links
        ]
        self._stale = tuple(filter(self._used.__contains__, readings.stale(at)))
        self._notices = senses.notices(at, held=self.held)

    def _alarms(self) -> tuple[Alarm, ...]:
        alarms: list[Alarm] = []
        if self.adopted:
            alarms += self._outages
        if self._latched:
            why = {"why": self._why} if self._why else {}
            alarms.append(Alarm(LATCHED_ERRORS[self.values["ee"] == EndEffectorState.RELEASE_ERROR], "", why))
        alarms += self._hold.alarms
        if self.adopted:
            alarms += self._notices
        if self._senses.now.supply.low and not self.held:
            alarms.append(Alarm("supply.low", "", {"warn_kpa": self._description.supply.warn_kpa}))
        if self.values["changer"] == ChangerState.FAULT:
            alarms.append(Alarm("changer.fault"))
        return tuple(alarms)

    @property
    def fault(self) -> bool:
        """Whether the tool changer is in FAULT and its unlock output is inactive."""
        return self.values["changer"] == ChangerState.FAULT and not self.values["unlock_valve"]

    @property
    def loose(self) -> str:
        """Reason why the tool of a held part is not proven locked (IL-05), a clause; empty: it is.

        Silent sensors alone do not count here: they raise an alarm of their own.
        """
        unlocking = bool(self.values["unlock_valve"])
        unclear = self._senses.now.tool is ToolEvidence.UNCLEAR and not (unlocking or self.fault)
        if unclear or self._is(self._fastened):
            return ""
        return loose(self._description, self._senses.now, unlocking=unlocking, fault=self.fault)

    def _is(self, condition: Condition) -> bool:
        """Return whether a condition of the automata holds."""
        state = self._execution.state
        return bool(condition(state.values, state.locations))

    @property
    def _why(self) -> str:
        return " ".join(filter(None, (self._reason, self._left)))


def _condition(network: Network, name: str) -> Condition:
    """Return a function that evaluates a condition of the automata without clocks."""
    return compile_integer(network, parse_expression(Text.plain(f"{name}()", f"function {name}")))
