"""One program of a tool in real time: its automata, its detectors, its lines."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from end_effector_hal.control import Answer, Status, model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, LineBusyError, WireError
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from timed_automata import load_network

from ._by_hand import drive, proof
from ._duties import Duties
from ._maintenance import Maintenance
from ._newest import Listener, Newest
from ._outputs import RETRY_US, LineWriter, Outputs
from ._question import ask
from ._relay import Relay, Rest
from ._sensor_fault import SensorFault
from ._venting import await_venting
from .boundary import NOBODY, Recorder

_log = logging.getLogger("end_effector_hal.runtime")
HUNG_US = 3_000_000  # longer than the longest wait for the line arbiter
OVERTAKEN = "The line arbiter took this program for dead and executed its will: it has begun anew."


class Unit:
    """Executes ``grip`` or ``tool_change`` against the line arbiter.

    All methods are thread-safe. What comes in is decided in the thread that brings it, and asked of the line arbiter
    there, so that no hand-over stands between a frame and a line; whatever waits is done in the unit's own thread.
    There ``on_status`` is called, once for each step of the automata, in order, after the lines are written. Trouble
    never leaves the unit, and what a listener or the recorder suffers never comes in: it becomes an alarm.

    A unit that the line arbiter took for dead is dead: in the middle of a grip, or when the lines are not as it left
    them, it begins anew, and adopts what it finds. Until it knows, it claims no grip.
    """

    def __init__(
        self,
        description: Description,
        program: str,
        lines: LineWriter,
        on_status: Listener | None = None,
        recorder: Recorder = NOBODY,
        fault: SensorFault | None = None,
    ) -> None:
        network = load_network(description.automata_path, model_constants(description))
        self._description, self._program, self._network = description, program, network
        self._recorder, self._lines = recorder, recorder.lines(lines)
        self._fault = fault or SensorFault()
        self._heard: dict[str, int] = {}
        self._faults: tuple[str, ...] = ()
        self._why, self._ending = "", "sigterm"
        self._told: tuple[str, ...] = ()
        self._be_unborn()
        self._relay = Relay(self._due, self._recorder.settle)
        self._newest = Newest(self._controller.status(), on_status)
        recorder.attend(lambda: self._relay.bring(lambda: self._acted([])))
        self._thread = threading.Thread(target=self._run, name=f"unit-{program}", daemon=True)

    def start(self) -> None:
        """Begin: read the lines, read the sensors, adopt."""
        self._thread.start()

    @property
    def alive(self) -> bool:
        """Whether the unit still works: a lease is renewed only while it does."""
        since = self._relay.busy_since
        return not self._newest.ended and (since is None or now_us() - since < HUNG_US)

    @property
    def status(self) -> Status:
        """The newest snapshot."""
        return self._newest.status

    def frame(self, frame: Frame) -> None:
        """A frame of the link; returns at once."""
        self._bring(lambda: self._controller.frame(frame, now_us()))

    def tell(self, **values: int) -> None:
        """Interface variables that another program says; returns at once."""
        self._relay.bring(lambda: self._acted(self._hear(values)))

    def lost(self, error: ArbiterError) -> None:
        """The connection to the line arbiter was lost; returns at once."""
        self._relay.bring(lambda: partial(self._lose, error))

    def latched(self, faults: tuple[str, ...]) -> None:
        """What the line arbiter has latched, in words; returns at once."""
        self._relay.bring(lambda: self._acted(self._know(faults)))

    def acknowledge(self) -> None:
        """Alarms about what is held that are over were seen: they are forgotten; returns at once."""
        self._bring(lambda: self._controller.acknowledge(now_us()))

    def command(self, name: str) -> Answer:
        """Give a command and wait for the decision of the automaton; an unlock waits before that for its proof."""
        if name == "unlock" and (changer := self._description.tool_changer):
            await_venting(self._newest, changer)
        return self._ask(lambda: self._decide(name))

    def set_actuator(self, name: str, active: bool, timeout_s: float | None = None) -> Answer:
        """Drive one actuator by hand (IL-12); success only with sensor evidence."""
        line = self._description.actuators[name].line

        def question() -> tuple[Answer, list[Status]]:
            answer = drive(self._controller, self._outputs, self._maintenance, line, active=active)
            return answer, [self._controller.status()] if answer.accepted else []

        answer = self._ask(question, waits=True)
        proven = answer.accepted and proof(self._newest, self._description, name, timeout_s, active=active)
        return proven or answer

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; False when the time is over or the unit has ended."""
        return self._newest.wait(until, timeout_s)

    def close(self, ending: str = "sigterm") -> None:
        """End in good order: the line arbiter does what the description declares for this ending."""
        self._ending = ending
        self._relay.end()
        if self._thread.is_alive():
            self._thread.join(5.0)
        elif self._thread.ident is None:  # never started: nothing was engaged
            with suppress(WireError):
                self._lines.close(())
            self._recorder.close()

    # In its turn, in whatever thread: nothing here waits.

    def _bring(self, what: Callable[[], list[Status]]) -> None:
        self._relay.bring(lambda: self._acted(what() if self._begun else []))

    def _acted(self, statuses: list[Status]) -> Rest | None:
        """Begins what follows from statuses; what is left to the unit's own thread."""
        if not statuses and not self._outputs.lost and self._extra() == self._told:
            return None
        return partial(self._told_of, statuses, self._outputs.begin(self._adopted(statuses)))

    def _due(self) -> int | None:
        times = (
            self._controller.deadline if self._begun else self._begin_at,
            self._outputs.retry_at,
            self._maintenance.ends_at,
        )
        return min((time for time in times if time is not None), default=None)

    # From here on: in the unit's thread.

    def _run(self) -> None:
        try:
            self._relay.run(lambda: self._act(self._begin()), lambda: partial(self._act, self._time_passed()))
            self._lines.close(self._duties.will(self.status, self._ending))
        except WireError as error:
            _log.warning("the line arbiter is not there to take the will of %s: %s", self._program, error)
        finally:
            # after a defect in here the lease is not renewed any more, and the line arbiter does what is declared
            self._newest.end()
            self._recorder.close()

    def _be_unborn(self) -> None:
        self._controller = self._recorder.controller(self._description, self._network, self._program)
        self._maintenance = Maintenance(self._description)
        self._duties = Duties(self._description, self._program, self._maintenance)
        self._outputs = Outputs(self._lines, self._duties.levels, self._duties.will)
        self._begun = False
        self._begin_at: int | None = None
        self._obstacle = ""

    def _begin(self) -> list[Status]:
        at = now_us()
        try:
            levels, sensor_fault = self._lines.levels(), self._fault.found()
        except WireError as error:
            self._obstacle, self._begin_at = str(error), at + RETRY_US
            return []
        self._begun, self._obstacle, self._begin_at = True, "", None
        statuses = self._controller.start(levels, at, sensor_fault=sensor_fault)
        return statuses + (self._controller.tell(self._heard, at) if self._heard else [])

    def _begin_anew(self, why: str) -> list[Status]:
        _log.warning("%s: %s", self._program, why)
        self._be_unborn()
        self._why = why
        return [self._now(), *self._begin()]

    def _lose(self, error: ArbiterError) -> None:
        if self._begun:
            self._outputs.lose(error, now_us())
            with suppress(WireError):
                self._lines.levels()  # a client tells each loss once more, to whoever calls next
        self._act([])

    def _look_again(self, statuses: list[Status]) -> list[Status]:
        """What may be told of these after the line arbiter was lost."""
        at = now_us()
        if at >= (self._outputs.retry_at or 0):
            try:
                if not self._outputs.agree(at, gripping=self._duties.grips(self._controller.status())):
                    return self._begin_anew(OVERTAKEN)
                self._outputs.retry(self._controller.status(), at)
            except LineBusyError as error:
                # its will is being executed, or somebody else has its lines
                return self._begin_anew(f"{OVERTAKEN} {error}")
            except WireError as error:
                self._outputs.alarm = str(error)
        if not self._outputs.lost:
            return [*statuses, self._now()]
        # before GRIPPED nothing is held: the will that holds must have arrived, or the owner may still unwind
        held = EndEffectorState.GRIPPED
        return [status for status in statuses if status.ee != held or self.status.ee == held]

    def _now(self) -> Status:
        status = self._controller.status()
        return status if self._begun else replace(status, at=now_us())

    def _hear(self, values: dict[str, int]) -> list[Status]:
        self._heard |= values
        return self._controller.tell(values, now_us()) if self._begun else []

    def _know(self, faults: tuple[str, ...]) -> list[Status]:
        self._faults = faults
        self._fault.heard(faults)
        return []  # nothing to do but to tell it

    def _time_passed(self) -> list[Status]:
        now = now_us()
        if not self._begun:
            return self._begin()
        if not self._outputs.lost and now >= (self._outputs.retry_at or now + 1):
            self._outputs.retry(self._controller.status(), now)
        if lines := self._maintenance.over(now):
            self._outputs.let_go(lines, now)
        return self._controller.advance(now)

    def _act(self, statuses: list[Status]) -> None:
        self._told_of(statuses, self._outputs.begin(self._adopted(statuses)))

    def _told_of(self, statuses: list[Status], unwritten: Sequence[Status]) -> None:
        """Ends what was begun for these; the later of them are unwritten yet. Then they are told."""
        statuses = self._written(statuses, unwritten)
        if self._outputs.lost:
            statuses = self._look_again(statuses)
        extra = self._extra()
        if not statuses and extra != self._told:
            statuses = [self._now()]
        for status in statuses:
            self._told = extra
            reason = f"{status.reason or self._why} {self._outputs.refused}".strip()
            told = replace(self._duties.seen(status), alarms=(*status.alarms, *extra), reason=reason)
            self._fault.see(told)
            self._newest.tell(told)

    def _extra(self) -> tuple[str, ...]:
        beside = (self._newest.trouble, self._recorder.trouble)
        notices = (self._obstacle, self._outputs.alarm, *self._faults, self._maintenance.notice, *beside)
        return tuple(text for text in notices if text)

    def _written(self, statuses: list[Status], unwritten: Sequence[Status]) -> list[Status]:
        """These, and what follows from what the line arbiter says to them."""
        self._outputs.finish()
        while unwritten:
            unwritten = self._outputs.begin(unwritten)
            self._outputs.finish()
        if not self._outputs.objected:
            return statuses
        self._outputs.objected = False
        more = self._controller.refused(now_us())
        return statuses + self._written(more, self._adopted(more))

    def _adopted(self, statuses: list[Status]) -> list[Status]:
        """Those that the lines are written for: not before they are adopted."""
        return [status for status in statuses if (status.ee if self._program == "grip" else status.changer)]

    def _decide(self, name: str) -> tuple[Answer, list[Status]]:
        if name == "grip" and self._maintenance.active:
            why = "a grip is refused while outputs are driven by hand."
            return Answer(False, f"IL-12: {why} {self._maintenance.notice}"), []
        if not self._begun:
            return Answer(False, f"The lines are not adopted yet. {self._obstacle}".rstrip()), []
        answer, statuses = self._controller.command(name, now_us())
        if answer.accepted:
            self._why = self._outputs.refused = ""
        return answer, statuses

    def _ask(self, question: Callable[[], tuple[Answer, list[Status]]], *, waits: bool = False) -> Answer:
        if self._newest.ended:
            return Answer(False, f"The {self._program} program has ended.")
        answer = ask(self._relay, question, self._acted, waits=waits)
        return answer or Answer(False, f"The {self._program} program does not answer.", decided=False)
