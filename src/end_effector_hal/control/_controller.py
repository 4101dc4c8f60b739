"""The controller of a tool: its automata with its detectors.

Inputs are events and time; outputs are statuses and a deadline.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.sensing import HoldMonitor, SensorSet
from end_effector_hal.signals import NESTED, Frame, PassingReadings, memory_of, recall
from end_effector_hal.vocabulary import Cause, EndEffectorState, Evidence, ToolEvidence
from timed_automata import Event, Execution, ExecutionSnapshot, Network, Observation, Step

from ._events import COMMANDS
from ._status import Answer, Status
from ._status_builder import StatusBuilder
from .words import blocking, no_maintenance, no_part, refusal


@dataclass(frozen=True, slots=True)
class ControllerSnapshot:
    """The state from which another controller of the same description makes the same decisions.

    Attributes:
        at: latest time that the controller has received, µs.
        status: the status at that time, with outputs, evidence, deadline and alarms.
        execution: locations, variables and clocks of the automata.
        memory: state of the detectors, the hold monitor and the status: last readings with their times, streaks,
            alarms.
    """

    at: int
    status: Status
    execution: ExecutionSnapshot
    memory: Mapping[str, Any]


class Foreseen(NamedTuple):
    """The statuses that an event leads to if it comes before ``until`` µs; their times are those of the question."""

    event: Event
    until: int
    statuses: list[Status]


FIRST_FRAME_US = 5_000_000
"""Time after which outputs found active count as unproven without a frame, µs.

It is long because the reader of the link may start later.
"""


class Controller:
    """Executes the automata of a tool; sans-IO: the same object runs in real and in virtual time.

    Time is an argument everywhere: µs on the monotonic clock. It never runs backwards: what arrives late, with an older
    stamp, counts as arriving now.

    Args:
        description: the tool.
        network: its automata with its constants inserted.
        observe: called with every observation of the automata: their inputs and their steps.
    """

    MEMORY: ClassVar = {
        "_senses": NESTED,
        "_hold": NESTED,
        "_statuses": NESTED,
        "_levels": dict[str, int],
        "_commanded": tuple[bool, ...],
        "_sensor_fault": bool,
        "_adopt_by": int | None,
        "_found_part": int,
        "_at": int,
    }

    def __init__(
        self,
        description: Description,
        network: Network,
        observe: Callable[[Observation], None] | None = None,
    ) -> None:
        self._description = description
        carrier = carrier_of(description)
        self._senses = SensorSet(description, carrier)
        self._hold = HoldMonitor(description, self._senses, carrier)
        automata = description.automata
        self._execution = Execution(network, automata.executed, automata.interface, observe=observe)
        self._statuses = StatusBuilder(description, self._execution, self._senses, self._hold)
        self._levels: dict[str, int] = {}
        self._announce: Callable[[Event, int], None] = _to_nobody
        self._several = len(description.part_names) > 1
        self._on_bus = bool(description.register_outputs)
        self._commanded = self._statuses.outputs
        """Which actuators are commanded to be active, in sequence order."""
        self._sensor_fault = False
        self._adopt_by: int | None = None
        self._found_part = 0
        self._at = 0

    @property
    def at(self) -> int:
        """Latest time that the controller has received, µs."""
        return self._at

    @property
    def deadline(self) -> int | None:
        """Time of the next change that needs no input, µs; None: there is none."""
        due = (self._execution.deadline, self._senses.deadline(self._at), self._adopt_by)
        return min([time for time in due if time is not None], default=None)

    def start(
        self,
        levels: Mapping[str, bool],
        at: int,
        *,
        sensor_fault: bool = False,
        grip_error: bool = False,
        part: str = "",
    ) -> list[Status]:
        """Start with the levels of the lines as they were found; adoption follows once the sensors are read.

        Args:
            levels: levels by line; a line that nobody knows is missing.
            at: time, µs.
            sensor_fault: one of the tool changer's sensors was latched before (IL-04); only a reset clears it.
            grip_error: GRIP_ERROR was latched before the program restarted by itself: what is active is not GRIPPED.
            part: the part that is held by the record; empty, or unknown: there is no record.
        """
        self._at, self._sensor_fault = at, sensor_fault
        number = self._description.part_number(part) if part and self._several else None
        self._found_part = -1 if number is None else number
        if not self._several:  # there is no other one, whatever is recorded
            self._found_part = 0
        self._statuses.part_recorded = self._found_part >= 0
        self._senses.use(max(self._found_part, 0))
        self._statuses.found, self._statuses.was_error = dict(levels), grip_error
        self._statuses.know({})
        down_us = self._senses.now.readings.down_us
        self._adopt_by = at + (max(FIRST_FRAME_US, down_us) if any(levels.values()) else down_us)
        return self._told(self._execution.start(at))

    def frame(self, frame: Frame, at: int | None = None) -> list[Status]:
        """Process one frame of the link, which arrived at ``frame.at`` and is processed at ``at``.

        The arrival decides whether the frame came before a time-out; the next wait begins when the frame is processed,
        so that no line is active for less than its time. A frame that waited until it was stale proves nothing any
        more. A frame with a stamp in the future or before the last one is not valid either. Both are refused, counted
        and reported.

        Args:
            frame: the frame.
            at: the time now, µs; default: the arrival of the frame, in virtual time.
        """
        if not self._senses.accepts(frame, frame.at if at is None else at):
            return self._refuse_frame(self._at if at is None else at)
        expired = self._senses.deadline(self._at)
        seen = max(frame.at, self._senses.at)  # after what another source has shown already
        self._at = max(self._at, seen, at or 0)
        statuses: list[Status] = []
        if expired is not None and expired < seen:
            statuses += self._look(expired, stamp=expired)[0]
        if self._adopt_by is not None:
            self._adopt_by = min(self._adopt_by, self._at + self._senses.now.readings.down_us)
        released = self._senses.now.nothing_gripped
        events = self._senses.frame(frame)
        self._write_levels()
        if events and not statuses:
            self._announced(events[0])
        held = self._statuses.held
        # until the lines are adopted a part is only perhaps held, and its sensors may not have been read yet
        told = self._hold.sample(seen, held=held and self._statuses.adopted)
        told |= self._statuses.noticed(self._at)
        for event in events:
            statuses += self._receive(event, self._at, seen)
        if not self._statuses.adopted and self._senses.conclusive:
            statuses += self._adopt(self._at)
        told |= self._senses.now.nothing_gripped is not released
        if seen < self._at and (due := self._senses.deadline(seen)) is not None and due <= self._at:
            # it turned stale between the frame and now: `deadline` says only what comes after now
            statuses += self._look(self._at)[0]
            told = True
        return self._watched(statuses if statuses or not (events or told) else [self.status()])

    def pass_over(self, frame: Frame) -> list[Status]:
        """Process a frame that changes no evidence: only the watch over a held part receives it."""
        self._at = max(self._at, frame.at)
        readings = PassingReadings(self._senses.now.readings, frame)
        told = self._hold.sample(
            frame.at, held=self._statuses.held and self._statuses.adopted, readings=readings
        )
        return [self.status()] if told else []

    def _refuse_frame(self, at: int) -> list[Status]:
        statuses = self.advance(at)
        told = self._statuses.noticed(self._at)
        return statuses if statuses or not told else [self.status()]

    def command(self, name: str, at: int, part: str = "") -> tuple[Answer, list[Status]]:
        """Execute a command, given by its channel; an edge of the automaton decides about acceptance.

        Args:
            name: the channel.
            at: time, µs.
            part: name of the part that is to be gripped; empty: the default one.
        """
        at = max(at, self._at)
        statuses = self._due_before(at)
        event = self._event(name, part)
        if event is None:
            return Answer(False, no_part(self._description, part)), statuses
        if name == "grip" and (why := self._no_grip(event, part, at)):
            return Answer(False, why), statuses
        if not statuses:
            self._announced(event)
        reaction = self._execution.receive(event, at)
        if not reaction.taken:
            why = self._refusal(name, at)
            return Answer(False, why), statuses + self._told(reaction.steps)
        if name == "grip" and self._several:
            self._senses.use(self._description.part_number(part) or 0)
        if name in ("grip", "drop"):
            self._statuses.blame(Cause.NONE, -1, self._at)
            self._hold.dropped()
        return Answer(True), statuses + self._told(reaction.steps)

    def refusal(self, name: str, part: str = "") -> str:
        """Return why a command would be refused now, as in its refusal; empty: it would be accepted.

        The call changes nothing. ``part``: the part that is to be gripped; empty: the default one.
        """
        event = self._event(name, part)
        if event is None:
            return no_part(self._description, part)
        if self._execution.takes(event):
            return self._faulty(self._at) if name == "grip" else ""
        return self._refusal(name, self._at, part)

    def _event(self, name: str, part: str) -> Event | None:
        """Return the event of a command; None: there is no such part."""
        if name != "grip" or not (part or self._several):
            return Event(name)
        number = self._description.part_number(part)
        return None if number is None else self._senses.grip_event(number)

    def _no_grip(self, event: Event, part: str, at: int) -> str:
        """Return why a part may not be gripped, as its own values or a device say; empty: the automata decide."""
        why = self._faulty(at)
        if not (why or self._several):
            return ""
        if self._execution.takes(event):
            return why
        return self._refusal("grip", at, part) if self._several else ""

    @property
    def blocking(self) -> dict[str, str]:
        """The reason of each interlock against a grip or an unlock now, a sentence; empty: none."""
        fault, senses = self._statuses.fault, self._senses.now
        said = blocking(self._description, self.status(), senses, self._at, fault=fault)
        return said | {"IL-07": said["IL-07"] or self._faulty(self._at)}

    @property
    def senses(self) -> SensorSet:
        """The sensors and what they prove, for display."""
        return self._senses

    @property
    def hold(self) -> HoldMonitor:
        """The watch over a held part, for display."""
        return self._hold

    def locations(self) -> ExecutionSnapshot | None:
        """Return the locations, variables and clocks of the automata; None: they were not started yet."""
        return self._execution.snapshot()

    def refused(self, at: int, *, unlock: bool = False) -> list[Status]:
        """Handle a refusal: the line arbiter did not activate an output that the last status demands.

        Args:
            at: time, µs.
            unlock: whether it is the unlock output.
        """
        at = max(at, self._at)
        statuses = self._due_before(at)
        return statuses + self._receive(Event("unlock_refused" if unlock else "grip_refused"), at)

    def acknowledge(self, at: int) -> list[Status]:
        """Remove the alarms that are over, because an operator has seen them; nothing else changes."""
        at = max(at, self._at)
        statuses = self._due_before(at)
        self._hold.acknowledge()
        return [*statuses, self.status()]

    def refuse_maintenance(self, *, active: bool) -> str:
        """Return why the line of an actuator may not be driven in maintenance now (IL-12); empty: it may."""
        if refused := no_maintenance(EndEffectorState(self._statuses.values["ee"]), held=self._statuses.held):
            return refused
        return self.blocking["IL-05"] if active else ""

    def advance(self, at: int) -> list[Status]:
        """Execute everything that is due at or before ``at``."""
        return self._advance(max(at, self._at))[0]

    def foresee(self) -> Iterator[Foreseen | None]:
        """Compute what each possible next input leads to, one input per item; the state does not change.

        An item is None if its input leads to nothing, or is a time-out. The caller stops the iteration when
        `discrete_state` changes.
        """
        takes, execution = self._execution.inputs, self._execution
        commands = [self._event(name, "") for name in COMMANDS]
        events = [event for event in (*self._senses.events, *commands) if event and event.channel in takes]
        for event in [*events, None]:
            found = execution.foresee(event)
            if event is None or found is None:
                yield None
                continue
            statuses = self._statuses.ahead(found.after)
            told = [statuses.step(step, step.at) for step in found.steps]
            yield Foreseen(event, found.until, told)

    def announce_to(self, listener: Callable[[Event, int], None]) -> None:
        """Call ``listener`` with an event and its time, µs, before the automata process it.

        Only events that find nothing due are announced, and of each call of `frame` or `command` only the first.
        """
        self._announce = listener

    @property
    def discrete_state(self) -> object:
        """A value that is equal for equal locations and variables."""
        return self._execution.state

    def status(self) -> Status:
        """Return the present status."""
        return self._statuses.status(self._at)

    def snapshot(self) -> ControllerSnapshot | None:
        """Return the present state for `resume`, without changing it; None: not started yet."""
        memory, execution = memory_of(self), self._execution.snapshot()
        return ControllerSnapshot(self._at, self.status(), execution, memory) if execution else None

    def resume(self, snapshot: ControllerSnapshot) -> None:
        """Continue from the state of another controller of the same description, instead of `start`.

        Raises:
            UsageError: the snapshot is of another description, or contradicts itself.
        """
        self._execution.resume(snapshot.execution)
        recall(self, snapshot.memory)
        self._statuses.know({})

    def _refusal(self, name: str, at: int, part: str = "") -> str:
        senses, fault, before = self._senses.now, self._statuses.fault, self._senses.now.part
        if self._several and name == "grip":  # what its own values say
            senses.use(self._description.part_number(part) or 0)
        tool = self._description.per_part[senses.part] if self._several else self._description
        try:
            return refusal(tool, name, self.status(), senses, at, fault=fault)
        finally:
            if senses.part != before:
                senses.use(before)

    def _faulty(self, at: int) -> str:
        """Return why a device prevents a grip, as a sentence; empty: none does."""
        why = self._hold.fault(at)
        return f"IL-07: {why}" if why else ""

    def _watched(self, statuses: list[Status]) -> list[Status]:
        """Return these statuses, and one more if a held part's tool just became loose or locked (IL-05)."""
        held = self._statuses.held and self._statuses.adopted
        loose = self._statuses.loose if held else ""
        return [*statuses, self.status()] if held and self._hold.tool(loose, self._at) else statuses

    def _announced(self, event: Event) -> None:
        """Announce an event that comes before anything that is due."""
        due = self._execution.deadline
        if due is None or due > self._at:
            self._announce(event, self._at)

    def _write_levels(self) -> None:
        if (levels := self._senses.levels) != self._levels:
            self._levels = levels
            self._execution.write(levels)

    def _advance(self, at: int) -> tuple[list[Status], int | None]:
        """Do as `advance` for an ``at`` that is not in the past; also return the next deadline, µs."""
        statuses: list[Status] = []
        while (due := self.deadline) is not None and due <= at:
            # what is late is taken now, and told as late: nobody may see a time at which nothing happened
            self._at = at
            statuses += self._look(at)[0]
            if self._adopt_by is not None and at >= self._adopt_by:
                statuses += self._adopt(at)
            statuses += self._told(self._execution.advance(at)) or [self.status()]
        self._at = at
        return statuses, due

    def _due_before(self, at: int) -> list[Status]:
        # inputs stamped at or before a deadline go before that time-out, but not before a reading turns stale
        same_instant = self._at == at
        statuses, due = self._advance(max(at - 1, self._at))
        self._at = at
        if not same_instant and (due is None or due > at):
            return statuses
        if (stale := self._senses.deadline(at - 1)) is not None and stale <= at:
            found, news = self._look(at)
            statuses += found if found or not news else [self.status()]
        return statuses

    def _look(self, at: int, stamp: int | None = None) -> tuple[list[Status], bool]:
        """Judge the sensors at ``at`` without a frame; return the statuses, and whether something changed."""
        events = self._senses.advance(at)
        self._write_levels()
        told = self._hold.sample(at, held=self._statuses.held and self._statuses.adopted)
        statuses = [status for event in events for status in self._receive(event, self._at, stamp)]
        return self._watched(statuses), bool(events) or told

    def _receive(self, event: Event, at: int, stamp: int | None = None) -> list[Status]:
        if event.channel not in self._execution.inputs:  # nobody waits for it: it is a level only
            return self._told(self._execution.write(event.writes, at))
        return self._told(self._execution.receive(event, at, stamp=stamp).steps)

    def _adopt(self, at: int) -> list[Status]:
        found, self._statuses.adopted, self._adopt_by = self._statuses.found, True, None
        self._statuses.know({})
        # of an output that nobody knows anything of there is no level: then the sensors decide, in doubt it is active
        unknown = self._description.may_be_unknown - found.keys()
        pairs = zip(self._description.ordered, self._senses.now.evidence, strict=True)
        gone = {actuator.line for (_, actuator), level in pairs if level is Evidence.GONE}
        actuators = [actuator for _, actuator in self._description.ordered]
        adopted = {
            f"adopted[{i}]": int(found.get(actuator.line, actuator.line in unknown - gone))
            for i, actuator in enumerate(actuators)
        }
        changer = self._description.tool_changer
        if changer is not None:
            locked = self._senses.now.tool in (ToolEvidence.LOCKED, ToolEvidence.ABSENT)
            adopted["adopted_unlock"] = int(found.get(changer.line, changer.line in unknown and not locked))
            adopted["adopted_fault"] = int(self._sensor_fault)
        adopted["adopted_error"] = int(self._statuses.was_error)
        adopted["adopted_part"] = self._found_part
        self._execution.write(adopted)  # before the event: its receiver reads these levels
        return self._receive(Event("adopt"), at)

    def _told(self, steps: Iterable[Step]) -> list[Status]:
        statuses = []
        for step in steps:
            self._at = max(self._at, step.at)
            statuses.append(self._statuses.step(step, self._at))
        if self._several and self._statuses.adopted:
            for event in self._senses.use(self._statuses.values["part"]):
                statuses += self._receive(event, self._at)
        return statuses + self._switched() if statuses and self._on_bus else statuses

    def _switched(self) -> list[Status]:
        """Process what the commands of the last steps change about the evidence."""
        before, self._commanded = self._commanded, self._statuses.outputs
        switched = [index for index, active in enumerate(self._commanded) if active is not before[index]]
        events = [
            event
            for index in switched
            for event in self._senses.switch(index, self._at, active=before[index] is False)
        ]
        statuses = [status for event in events for status in self._receive(event, self._at)]
        return statuses if statuses or not events else [self.status()]


def _to_nobody(_: Event, __: int) -> None:
    """Ignore an announced event."""
