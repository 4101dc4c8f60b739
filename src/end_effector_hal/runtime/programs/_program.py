"""A program in real time: a controller with its worker and its outputs."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Protocol

from end_effector_hal.arbiter import PredicatePublisher
from end_effector_hal.control import (
    Answer,
    Status,
    held_words,
    network_of,
    restart_events,
    unread_e_stop,
)
from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, WireError
from end_effector_hal.runtime._reload import reload_answer
from end_effector_hal.runtime.boundary import NULL_RECORDER, Recorder
from end_effector_hal.runtime.outputs import (
    RESTARTED,
    RETRY_US,
    LineWriter,
    Maintenance,
    OutputMapping,
    Outputs,
)
from end_effector_hal.runtime.stream import (
    GO_ON,
    MAINTENANCE_WORDS,
    OF_CHANGER,
    RELOAD,
    SWITCH_WORDS,
    TOO_LATE,
    WORDS,
    ProgramCommand,
)
from end_effector_hal.sensing import JudgedReadings, SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import (
    Alarm,
    Command,
    EndEffectorState,
    LastWill,
    with_since,
)
from end_effector_hal.wires import now_us
from end_effector_hal.wires.sensors import SensorHealth
from timed_automata import Event

from ._adoption import Adoption, DeclaredDeadError
from ._foresight import Foresight
from ._inline_worker import InlineWorker
from ._latched_faults import LatchedFaults
from ._latest_status import LatestStatus, Listener
from ._maintenance_drive import drive, proof
from ._release_proof import await_release
from ._sensor_fault import FaultKeeper, SensorFault
from ._serial_worker import FollowUp, SerialWorker
from ._written_status import as_written, with_reasons

_log = logging.getLogger("end_effector_hal.runtime")
HUNG_US = 3_000_000  # longer than the longest wait for the line arbiter
STILL_US = 30_000_000
"""Time for which a reload blocks activations, µs; longer than all programs of a tool take to end and to start again."""
RELOADING = "Another description is about to be taken over: nothing is activated meanwhile."
ACTIVATING = ("grip", "unlock", "activate")
"""Commands that begin with an activation; all others only deactivate, or change nothing."""
LOST = "The line arbiter is lost: nothing was written, and nothing will be. Give the command again when it is back."
UNWRITTEN = (
    "The line arbiter was lost before all of it was written. Nothing of it is written later; the program has restarted "
    "and adopts the lines as they are when the line arbiter is back."
)


CAME_LATE = (
    "A sensor fault of the tool changer was latched before the start, but the line arbiter read it from its disk "
    f"too late; {RESTARTED}"
)


def no_health() -> SensorHealth:
    """Return that the program reads no sensors itself."""
    return SensorHealth({}, None)


def no_output(name: str, active: bool) -> Answer:
    """Refuse to switch a plain output."""
    return Answer(False, f"This HAL does not switch the plain output {name}.")


class ToolLines(LineWriter, FaultKeeper, Protocol):
    """The methods of the line arbiter that a program calls."""


class Program:
    """Executes the automata of a tool; all methods are thread-safe.

    The line arbiter stores the sensor fault of the tool changer until a reset (IL-04). The lines of maintenance are
    deactivated when its lease expires (IL-12).

    1. The automata decide in the thread that delivers an event, and that thread sends the write to the line arbiter.
       The program's own thread waits for the reply.
    2. The program's own thread calls the listener, once for each step of the automata, in order, after the lines are
       written.
    3. Errors do not leave the program, and errors of a listener or of the recorder do not enter it: each becomes an
       alarm.
    4. A program that was declared dead in the middle of a grip, or that does not find the lines as it left them,
       restarts, and adopts the lines as they are. A line that it has activated and that cannot be read back counts as
       active, whatever its sensors show. Until the lines are read, it reports no grip. A latched GRIP_ERROR stays.
    5. Nothing is reported as held before all requested writes are applied: a deactivation may wait (IL-10).
    6. While the line arbiter is lost, no command begins. Decisions that are not written when their command ends are
       discarded: the program restarts, and nothing of them is written later or left as a last will.

    Args:
        description: the tool.
        lines: the line arbiter.
        on_status: called with each status.
        recorder: records the boundary.
        clock: returns the time, µs.
        publisher: sends what the sensors prove to the line arbiter; None: another process does.
        worker: runs the jobs; an `InlineWorker` if `begin` and `work` are called instead of `start`.
    """

    def __init__(
        self,
        description: Description,
        lines: ToolLines,
        on_status: Listener | None = None,
        recorder: Recorder = NULL_RECORDER,
        clock: Callable[[], int] = now_us,
        publisher: PredicatePublisher | None = None,
        worker: type[SerialWorker | InlineWorker] = SerialWorker,
    ) -> None:
        self._description, self._clock, self._publisher = description, clock, publisher
        self._network = network_of(description)
        self._recorder, self._lines, self._arbiter = recorder, recorder.lines(lines), lines
        self._held = False  # as it was last known, before a restart
        self._commanded = False  # what is being written is the beginning of a command that activates nothing
        self._latched = LatchedFaults({})
        self._still_until = 0
        self._why, self._ending = "", "sigterm"
        self._begun_at, self._count = clock(), 0
        self._shown_notices: tuple[Alarm, ...] = ()
        self._waits = worker is SerialWorker
        self._fault = SensorFault(lines)
        self._look_at: int | None = None  # µs at which the faults of the line arbiter are read again
        self._link_faults: tuple[Alarm, ...] = ()
        self._reset()
        self.on_readings: Callable[[JudgedReadings], None] | None = None
        """Called with what the sensors read, in a thread of the program; it must not wait. None: nobody listens."""
        self._read: tuple[SensorSet, int] | None = None
        self._worker = worker(self._due, self._time_passed, self._flush, clock, self._prepare)
        self._latest = LatestStatus(self._adoption.controller.status(), on_status)
        recorder.attend(self._look_around)
        self._thread = threading.Thread(target=self._run, name="program", daemon=True)

    def start(
        self,
        switch: Callable[[str, bool], Answer] = no_output,
        health: Callable[[], SensorHealth] = no_health,
    ) -> None:
        """Start the thread: read the lines, read the sensors, adopt.

        Args:
            switch: switches a plain output for a client of the stream.
            health: returns the state of the sensor links and inputs, for clients of the stream.
        """
        self._switch = switch
        self._thread.start()
        self._recorder.serve(self._asked, lambda: self.alive, self._look_around, health)

    def begin(self) -> None:
        """Begin in the calling thread instead of the program's own; for virtual time."""
        self._worker.begin(self._begin)

    @property
    def due(self) -> int | None:
        """Time of the next action that needs no event, µs; in virtual time, call `work` then. None: there is none."""
        return self._due()

    def work(self) -> None:
        """Do everything that is due now."""
        self._worker.work()

    def leave(self, ending: str = "sigterm") -> None:
        """End in good order a program that has no thread; raises WireError."""
        self._worker.end()
        self._latest.end()
        self._lines.close(self._last_will(ending))

    @property
    def waits(self) -> bool:
        """Whether each frame triggers a check if the line arbiter is back, or has applied the last writes."""
        return self._adoption.outputs.lost or self._adoption.withholds

    @property
    def alive(self) -> bool:
        """Whether the program still works; its lease is renewed only while it does."""
        since = self._worker.busy_since
        return not self._latest.ended and (since is None or self._clock() - since < HUNG_US)

    @property
    def status(self) -> Status:
        """The latest status."""
        return self._latest.status

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; return False on a time-out or when the program has ended."""
        return self._latest.wait(until, timeout_s)

    def frame(self, frame: Frame) -> None:
        """Submit a frame of the link; return at once."""
        self._worker.submit(partial(self._frame, frame))

    def pass_over(self, frame: Frame) -> None:
        """Process a frame that is known to leave the evidence unchanged; for virtual time."""
        if self._adoption.begun and (statuses := self._adoption.controller.pass_over(frame)):
            self._submit(lambda: statuses)

    def passed_over(self, samples: int, at: int) -> None:
        """Account for all these frames together; for virtual time. ``at``: time of the last one, µs."""
        self.senses.pass_over(samples, at)
        if self._publisher is not None:
            self._publisher.repeat()

    @property
    def senses(self) -> SensorSet:
        """The sensors and what they prove, for display and for virtual time."""
        return self._adoption.controller.senses

    def arbiter_lost(self, error: ArbiterError) -> None:
        """Report to the program that the connection to the line arbiter was lost; return at once."""
        self._worker.submit(lambda: partial(self._lose, error))

    def faults_changed(self, faults: Mapping[str, str]) -> None:
        """Submit the faults that the line arbiter has latched, as sentences by name; return at once."""
        self._worker.submit(lambda: self._reaction(self._keep_faults(faults)))

    def acknowledge(self) -> None:
        """Acknowledge alarms about a held part, which clears those that are over; return at once."""
        self._submit(lambda: self._adoption.controller.acknowledge(self._clock()))

    def stand_still(self, for_us: int = STILL_US) -> Answer:
        """Block activations for ``for_us`` µs if the program is at rest now; 0 ends the block.

        It is called before a reload, so that no grip begins meanwhile.
        """

        def question() -> tuple[Answer, list[Status]]:
            if for_us and (why := self._unrest()):
                return Answer(False, f"{why} The description that runs stays in force."), []
            self._still_until = self._clock() + for_us
            return Answer(True), [self._adoption.controller.status()] if self._adoption.begun else []

        return self._ask(question)

    def command(self, name: str, part: str = "", *, until_us: int | None = None) -> Answer:
        """Give a command and wait for the decision of the automaton; after ``until_us`` the command is refused.

        ``part`` is the part that a grip is for; empty: the default one.

        An unlock first waits for its proof (IL-01), unless the program has no thread.
        """
        if self._waits and name == "unlock" and (changer := self._description.tool_changer):
            await_release(self._latest, changer)
        return self._ask(partial(self._decide, name, part, until_us), waits=name not in ACTIVATING)

    def close(self, ending: str = "sigterm") -> None:
        """End in good order: the line arbiter does what the description declares for this ending."""
        self._ending = ending
        self._worker.end()
        if self._thread.is_alive():
            self._thread.join(5.0)
        elif self._thread.ident is None:  # never started: nothing was engaged
            with suppress(WireError):
                self._lines.close(())
            self._recorder.close()

    def set_actuator(self, name: str, active: bool, timeout_s: float | None = None) -> Answer:
        """Drive one actuator in maintenance (IL-12); success requires sensor evidence.

        Args:
            name: name of the actuator.
            active: the level that its output gets.
            timeout_s: longest wait for the evidence; default: the time that the actuator has in a grip or a release.
        """
        answer = self._drive(name, None, active=active)
        proven = answer.accepted and proof(self._latest, self._description, name, timeout_s, active=active)
        return proven or answer

    def _drive(self, name: str, until_us: int | None, *, active: bool) -> Answer:
        """Write the line of an actuator in maintenance; refuse if ``until_us`` is over."""
        line = self._description.actuators[name].line

        def question() -> tuple[Answer, list[Status]]:
            at = self._clock()
            if until_us is not None and at > until_us:
                return Answer(False, TOO_LATE), []
            if obstacle := self._obstacle("activate" if active else "deactivate", at):
                return Answer(False, obstacle, decided=not self._adoption.lost), []
            answer = drive(self._adoption, self._maintenance, line, at, active=active)
            return answer, [self._adoption.controller.status()] if answer.accepted else []

        return self._ask(question, waits=True)

    def _keep_faults(self, faults: Mapping[str, str]) -> list[Status]:
        """Keep the latched faults; a new stop cancels a running grip, and a sensor fault is looked for again."""
        before, self._latched, self._look_at = self._latched, LatchedFaults(faults), self._clock()
        adoption = self._adoption
        if before.stopped or not self._latched.stopped or not adoption.begun:
            return []  # only the notices change
        gripping = adoption.outputs.mapping.gripping(adoption.controller.status())
        return adoption.controller.command("cancel", self._clock())[1] if gripping else []

    def _due(self) -> int | None:
        """Return the time of the next action that needs no event, µs."""
        look_at = self._look_at if self._adoption.begun else None
        repeats_at = self._publisher.repeats_at if self._publisher and self._adoption.begun else None
        due = (self._adoption.due, self._maintenance.ends_at, look_at, repeats_at)
        return min((at for at in due if at is not None), default=None)

    def _on_time(self, at: int) -> list[Status]:
        """Do everything that is due at ``at``; the program must have begun."""
        adoption = self._adoption
        if lines := self._maintenance.over(at):
            adoption.outputs.let_go(lines, adoption.controller.status(), at)
        if self._look_at is not None and at >= self._look_at:
            try:
                late, self._look_at = self._fault.came_late(), None
            except WireError:
                late, self._look_at = False, at + RETRY_US
            if late:
                return self._restart(CAME_LATE)
        statuses = adoption.time_passed(at)
        if self._publisher is not None and self._publisher.repeats:
            self._publisher.repeat(at)
        return statuses

    def _obstacle(self, name: str, at: int, part: str = "") -> str:
        """Return a sentence why a command at ``at`` µs is refused before it reaches the automata; empty: it is not."""
        adoption = self._adoption
        if not adoption.begun:
            return f"The lines are not adopted yet. {adoption.alarm or ''}".rstrip()
        if adoption.outputs.lost and name != "acknowledge":
            lost = "Nothing can be activated while the line arbiter is lost."
            return lost if name in ACTIVATING else LOST
        if name == "grip" and self._maintenance.lines:
            return f"IL-12: a grip is refused during maintenance. {self._maintenance.notice}"
        if name in ACTIVATING:
            if self._still_until > at:
                return RELOADING
            return self._latched.refuses or self._unread(name, at, part)
        return ""

    def _unread(self, name: str, at: int, part: str) -> str:
        """Return a sentence if the e-stop is not read; empty: it is, or the automata refuse for another reason."""
        controller = self._adoption.controller
        why = unread_e_stop(self._description, controller.senses.now.readings, at)
        return "" if why and name not in MAINTENANCE_WORDS and controller.refusal(name, part) else why

    def _unrest(self) -> str:
        """Return a sentence why the program is not at rest; empty: it is."""
        if not self._adoption.begun:
            return self._obstacle("", self._clock())
        status = self._adoption.controller.status()
        if status.held:
            return f"{held_words(status.ee).capitalize()}: drop it first."
        if status.command is not Command.NONE:
            return f"{status.command.label} is under way: wait for its end, or cancel it."
        if status.ee not in (EndEffectorState.STAND_BY, EndEffectorState.OFF):
            return f"The end-effector is {status.ee.name}: this needs STAND_BY."
        return self._maintenance.notice

    def _decide(self, name: str, part: str = "", until_us: int | None = None) -> tuple[Answer, list[Status]]:
        at = self._clock()
        if until_us is not None and at > until_us:
            return Answer(False, TOO_LATE), []
        adoption = self._adoption
        if name not in ACTIVATING:
            adoption.look(at)
        if obstacle := self._obstacle(name, at, part):
            return Answer(False, obstacle, decided=not adoption.lost), []
        answer, statuses = adoption.controller.command(name, at, part)
        self._commanded = answer.accepted and bool(statuses) and name not in ACTIVATING
        if answer.accepted:
            self._why = adoption.outputs.refused[name in OF_CHANGER] = ""
            if name == "reset":
                self._fault.reset()
        return answer, statuses

    def see_link_faults(self, faults: tuple[Alarm, ...]) -> None:
        """Store the alarms about answers of single devices; callable from any thread."""
        if faults != self._link_faults:
            self._link_faults = faults
            self._look_around()

    def _notices(self) -> tuple[Alarm, ...]:
        """Return the alarms that do not come from the controller."""
        listener, recorder = self._latest.trouble, self._recorder.trouble
        active = self._maintenance.notice
        return tuple(filter(None, (
            self._adoption.alarm, self._adoption.outputs.alarm, *self._latched.alarms, *self._link_faults,
            Alarm("listener.failed", "hal", {"text": listener}) if listener else None,
            Alarm("recording.failed", "hal", {"text": recorder}) if recorder else None,
            Alarm("maintenance.active", "", {"text": active}) if active else None,
        )))  # fmt: skip

    def _completed(self, status: Status, notices: tuple[Alarm, ...]) -> Status:
        """Return a status of the controller with all that only the program knows."""
        completed = with_reasons(status, self._why, self._adoption.outputs.refused)
        if notices or status.alarms:
            alarms = with_since((*status.alarms, *notices), self.status.alarms, status.at)
            completed = replace(completed, alarms=alarms)
        return as_written(completed, self._description, self._adoption, self._maintenance, held=self._held)

    def _publish_one(self, status: Status) -> None:
        self._fault.update(status)
        self._latest.publish(status)

    def _prepare(self) -> bool:
        return self._adoption.begun and self._foresight.go_on()

    def _hasten(self, event: Event, at: int) -> None:
        """Begin to write what an event leads to, if that is worked out already."""
        if write := self._foresight.of(event, at):
            if self._publisher is not None:
                self._publisher.publish()  # the line arbiter receives what the sensors prove before what they lead to
            self._adoption.outputs.hasten(write, at)

    def _look_around(self) -> None:
        """Submit a check for changes outside the automata."""
        self._worker.submit(lambda: self._reaction([]))

    def _asked(self, asked: ProgramCommand) -> Answer:
        """Execute a command of a client of the stream; the answer has the number of a status that follows it."""
        return replace(self._execute(asked), count=self._count)

    def _execute(self, asked: ProgramCommand) -> Answer:
        if asked.command == "acknowledge":
            self.acknowledge()
            return Answer(True)
        if asked.command == RELOAD:
            answer = self.stand_still()
            if answer.accepted and not (answer := reload_answer(self._description)).accepted:  # it may wait
                self.stand_still(0)
            return answer
        if asked.command == GO_ON:
            return self.stand_still(0)
        if asked.command in SWITCH_WORDS:
            return self._switch(asked.name, asked.command == SWITCH_WORDS[0])
        if asked.command not in MAINTENANCE_WORDS:
            return self.command(asked.command, asked.name, until_us=asked.until_us)
        if asked.name not in self._description.actuators:
            there = ", ".join(self._description.sequence)
            return Answer(False, f"There is no actuator called {asked.name!r}; there are {there}.")
        # answered when the line is written: waiting for its sensor would delay the commands of other clients
        return self._drive(asked.name, asked.until_us, active=asked.command == "activate")

    # Jobs: in whatever thread has the turn, and nothing here waits.

    def _frame(self, frame: Frame) -> FollowUp | None:
        controller, publisher = self._adoption.controller, self._publisher
        if not self._adoption.begun:
            if publisher is not None:
                publisher.publish(frame)  # nothing is proven yet, but what objects is latched
            return None
        refused = controller.senses.stamps.refused
        statuses = controller.frame(frame, self._clock())
        if publisher is None:
            return self._reaction(statuses)
        publisher.publish(frame if controller.senses.stamps.refused > refused else None)
        follow_up = self._reaction(statuses)
        if follow_up is None:
            publisher.repeat()
            return None

        def finish() -> None:
            follow_up()
            publisher.repeat()  # not before the reply: the line arbiter answers predicates before writes

        return finish

    def _flush(self) -> None:
        """Pass on the readings and the records of a job; after the lines are written."""
        now = self.senses, self.senses.revision
        if now != self._read and (self.on_readings is not None or self._recorder.is_read):
            self._read, readings = now, self.senses.now.readings.judged(self._clock())
            if self.on_readings is not None:
                self.on_readings(readings)
            self._recorder.readings(readings)
        self._recorder.flush()

    def _submit(self, event: Callable[[], list[Status]]) -> None:
        self._worker.submit(lambda: self._reaction(event()) if self._adoption.begun else None)

    def _ask(self, question: Callable[[], tuple[Answer, list[Status]]], *, waits: bool = False) -> Answer:
        given_up: list[str] = []

        def job() -> tuple[Answer, FollowUp | None]:
            answer, statuses = question()
            adoption, follow_up = self._adoption, self._reaction(statuses)
            if follow_up is None or not self._commanded:
                return answer, follow_up

            def finish() -> None:
                follow_up()
                if adoption is not self._adoption:
                    given_up.append(self._why)

            return answer, finish

        if self._latest.ended:
            return Answer(False, "The HAL has ended.")
        answer = self._worker.ask(job, waits=waits)
        if given_up:
            return Answer(False, given_up[0], decided=False)
        return answer or Answer(False, "The HAL does not answer.", decided=False)

    def _reaction(self, statuses: list[Status]) -> FollowUp | None:
        """Begin to write what the statuses request; the returned follow-up waits for the reply and publishes them."""
        if not statuses and not self.waits and self._notices() == self._shown_notices:
            return None
        return partial(self._finish, statuses, self._adoption.outputs.begin(statuses))

    # From here on: in the program's thread.

    def _run(self) -> None:
        try:
            self._worker.run(self._begin)
            self._lines.close(self._last_will(self._ending))
        except WireError as error:
            _log.warning("the line arbiter cannot be reached for the last will: %s", error)
        finally:
            # after a defect in here the lease is not renewed any more, and the line arbiter does what is declared
            self._latest.end()
            self._recorder.close()

    def _last_will(self, ending: str) -> LastWill:
        """Return the last will for an ending; it is empty for lines that are not adopted."""
        return self._adoption.outputs.mapping.last_will(self.status, ending) if self._adoption.begun else ()

    def _begin(self) -> None:
        self._act(self._adopt())

    def _act(self, statuses: list[Status]) -> None:
        if follow_up := self._reaction(statuses):
            follow_up()

    def _reset(
        self,
        activated: frozenset[str] = frozenset(),
        known: Mapping[str, bool] | None = None,
        *,
        grip_error: bool = False,
    ) -> None:
        controller = self._recorder.controller(self._description, self._network)
        if self._publisher is not None:
            self._publisher.use(controller.senses)
        self._maintenance = Maintenance(self._description)
        outputs = Outputs(self._lines, OutputMapping(self._description, self._maintenance), known)
        self._adoption = Adoption(controller, outputs, self._lines, activated, grip_error=grip_error)
        self._foresight = Foresight(controller, outputs)
        controller.announce_to(self._hasten)

    def _adopt(self) -> list[Status]:
        return self._adoption.begin(self._clock(), self._fault.found)

    def _restart(self, why: str) -> list[Status]:
        self._fault.restarted()
        _log.warning("%s", why)
        before, adoption = self.status, self._adoption
        self._held = before.held
        states = before.ee, adoption.controller.status().ee
        # a restart before the adoption keeps the error of the restart before
        grip_error = EndEffectorState.GRIP_ERROR in states or (not before.adopted and adoption.grip_error)
        self._reset(adoption.outputs.activated, adoption.outputs.known, grip_error=grip_error)
        self._why = why
        now = self._adoption.now(self._clock())
        return [replace(now, events=restart_events(before.ee, before.changer, now.at)), *self._adopt()]

    def _give_up(self) -> list[Status]:
        """Discard decisions that cannot be written, and their last will; restart."""
        with suppress(WireError):
            self._arbiter.ask(
                {}, ()
            )()  # it is lost: the next connection begins with this last will, which holds
        return self._restart(UNWRITTEN)

    def _time_passed(self) -> FollowUp | None:
        return self._reaction(self._on_time(self._clock()) if self._adoption.begun else self._adopt())

    def _lose(self, error: ArbiterError) -> None:
        self._adoption.lose(error, self._clock())
        self._act([])

    def _finish(self, statuses: list[Status], unwritten: Sequence[Status]) -> None:
        """Wait for the writes that were begun, write the ``unwritten`` statuses too, and publish all of them."""
        outputs, commanded, self._commanded = self._adoption.outputs, self._commanded, False
        outputs.complete(unwritten)
        while outputs.objected:
            unlock = outputs.objected.pop()
            more = self._adoption.controller.refused(self._clock(), unlock=unlock)
            statuses = statuses + more
            outputs.complete(outputs.begin(more))
        if outputs.lost:
            self._look_at = self._clock() + RETRY_US
            try:
                statuses = self._adoption.compare(statuses, self.status, self._clock())
            except DeclaredDeadError as error:
                statuses = self._restart(str(error))
            else:
                ended = outputs.owes and self._adoption.controller.status().command is Command.NONE
                if outputs.lost and (commanded or ended):
                    statuses = self._give_up()
        if not self._adoption.outputs.lost:
            statuses = self._adoption.after_writes(statuses, self.status, self._clock())
        self._publish(statuses)

    def _publish(self, statuses: list[Status]) -> None:
        notices, at = self._notices(), self._clock()
        if not statuses and notices != self._shown_notices:
            statuses = [self._adoption.now(at)]
        for status in statuses:
            self._shown_notices = notices
            self._count += 1
            completed = replace(self._completed(status, notices), begun=self._begun_at, count=self._count)
            obstacles = {word: why for word in WORDS if (why := self._obstacle(word, at))}
            self._recorder.published(completed, obstacles)
            self._publish_one(completed)
