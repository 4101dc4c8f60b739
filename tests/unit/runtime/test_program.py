"""A program with lines and a clock of the test; its worker has no thread: what it would do is done by the test."""

from __future__ import annotations

import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from queue import Empty
from types import FrameType
from typing import Any

import pytest

from end_effector_hal.arbiter import HAL, SENSOR_FAULT, PredicatePublisher, client_lines
from end_effector_hal.control import Answer, EventKind, Status, ToolEvent
from end_effector_hal.control._status_builder import StatusBuilder
from end_effector_hal.control.goals import Outcome, judge
from end_effector_hal.description import Description, EStop, load, profile_path
from end_effector_hal.errors import ArbiterError, LineRefusedError
from end_effector_hal.runtime import InlineWorker, Program
from end_effector_hal.runtime.boundary import NULL_RECORDER, Recorder, open_recorder, open_stream
from end_effector_hal.runtime.programs._foresight import Foresight
from end_effector_hal.runtime.programs._program import UNWRITTEN
from end_effector_hal.runtime.stream import ProgramCommand
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Frame, Value
from end_effector_hal.vocabulary import (
    NO_PART,
    Cause,
    ChangerState,
    Command,
    EndEffectorState,
    LastWill,
    LastWillStep,
    WrittenPart,
)
from tests.support.declared import declared
from tests.support.patience import wait_until

PERIOD = 20_000
REFUSED = "IL-05: not now."
QUIET: dict[str, Value] = {
    "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "cylinder_extended": False, "cylinder_retracted": True,
    "locked": True, "unlocked": False, "tool_present": True, "in_stand": True, "estop_ok": True,
}  # fmt: skip


class Lines:
    """Lines in memory, with the latched faults; ``count`` counts calls up to a write, ``away``: nobody answers,
    ``refused``: the line whose activation is refused, ``will``: the last one, ``delay_us``: how long writes wait.
    """

    def __init__(self, description: Description) -> None:
        self.active = dict.fromkeys(client_lines(description, HAL), False)
        self.faults: dict[str, str] = {}
        self.count: Count | None = None
        self.away = False
        self.refused = ""
        self.will: LastWill = ()
        self.delay_us = 0

    def levels(self) -> Mapping[str, bool]:
        self._answer()
        return dict(self.active)

    def recorded_part(self) -> str:
        return ""

    def declared_dead(self) -> bool:
        return False

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        if self.count is not None and levels:
            self.count.stop()

        def wait() -> int:
            self._answer()
            if levels.get(self.refused):
                raise LineRefusedError(REFUSED)
            self.active |= levels
            self.will = tuple(will)
            return self.delay_us

        return wait

    def close(self, will: Sequence[LastWillStep]) -> None:
        del will

    def status(self) -> dict[str, Any]:
        self._answer()
        return {"faults": self.faults}

    def latch(self, fault: str, why: str) -> None:
        self.faults[fault] = why

    def clear(self, fault: str) -> None:
        del self.faults[fault]

    def _answer(self) -> None:
        if self.away:
            raise ArbiterError("the line arbiter is away.")


class Count:
    """Counts calls of Python functions in one thread, up to the write of a line; names are file:function."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()
        self.reached: Counter[str] | None = None

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        if event == "call" and self.reached is None:
            self.calls[f"{Path(frame.f_code.co_filename).name}:{frame.f_code.co_qualname}"] += 1

    def stop(self) -> None:
        self.reached = self.reached or self.calls.copy()

    @contextmanager
    def counting(self) -> Iterator[None]:
        sys.setprofile(self)
        try:
            yield
        finally:
            sys.setprofile(None)


class Tool:
    """The program of the shipped tool, its sensors as its lines are."""

    def __init__(
        self,
        description: Description | None = None,
        recorder: Recorder = NULL_RECORDER,
    ) -> None:
        self.description = description or load(profile_path())
        self.lines, self.at, self._number = Lines(self.description), 1_000_000, 0
        self.statuses: list[Status] = []
        self.program = Program(
            self.description,
            self.lines,
            self.statuses.append,
            recorder,
            clock=lambda: self.at,  # type: ignore[arg-type]
        )
        self.worker = self.program._worker
        self.worker.begin(self.program._begin)

    def frame(self) -> Frame:
        self.at, self._number = self.at + PERIOD, self._number + 1
        shown = dict(QUIET)
        for name, actuator in self.description.ordered:
            if self.lines.active[actuator.line]:
                shown[actuator.channel] = -80_000 if name.endswith("vacuum") else 600_000
                if name == "cylinder":
                    shown |= {"cylinder_extended": True, "cylinder_retracted": False}
        if self.description.tool_changer and self.lines.active[self.description.tool_changer.line]:
            shown |= {"locked": False, "unlocked": True}
        noise = self._number % 4
        shown |= {name: (shown[name] or 0) + noise for name in ("bottom", "cylinder", "top", "supply")}
        return Frame(self.at, self._number, self._number * 20, shown)

    def idle(self) -> None:
        """What the worker's thread does until it sleeps."""
        self.worker.work()
        while self.program._prepare():
            pass

    def run(self, frames: int) -> None:
        for _ in range(frames):
            self.program.frame(self.frame())
            self.idle()

    def lose(self) -> None:
        """The line arbiter goes away, and the program hears of it."""
        self.lines.away = True
        self.program.arbiter_lost(ArbiterError("the line arbiter is away."))

    def latch(self, faults: dict[str, str]) -> None:
        """The line arbiter says which faults it has latched."""
        self.program.faults_changed(faults)
        self.idle()

    def play(self, *orders: str | int) -> None:
        """Commands that are accepted, and frames between them."""
        for order in orders:
            if isinstance(order, str):
                assert self.command(order).accepted, order
            else:
                self.run(order)

    def command(self, name: str, until_us: int | None = None, waits_us: int = 0) -> Answer:
        """Give a command, which waits for ``waits_us`` before it is decided."""
        return self.ask(lambda: self.program.command(name, until_us=until_us), waits_us)

    def ask(self, question: Callable[[], Answer], waits_us: int = 0) -> Answer:
        """In a thread of its own, as a command comes; it waits for what only the worker does."""
        answers: list[Answer] = []

        def command() -> None:
            with self.lines.count.counting() if self.lines.count else nullcontext():
                answers.append(question())

        thread = threading.Thread(target=command)
        with self.worker._turn if waits_us else nullcontext():
            thread.start()
            wait_until("it waits", lambda: bool(self.worker._jobs) or not waits_us)
            self.at += waits_us
        while thread.is_alive():
            with suppress(Empty):  # its answer may have come, and the thread not have ended yet
                self.worker._bell.get(timeout=0.1)
            self.worker.work()
            thread.join(0.01)
        self.idle()
        return answers[0]


def gripping(tool: Tool) -> list[bool]:
    """The lines of the actuators."""
    return [tool.lines.active[actuator.line] for _, actuator in tool.description.ordered]


@pytest.fixture
def tool() -> Iterator[Tool]:
    """A tool in STAND_BY; whatever happens to it, the events of its statuses lead from each state to the next."""
    tool = Tool()
    tool.run(60)
    assert tool.program.status.ee is EndEffectorState.STAND_BY
    yield tool
    state = None
    for status in tool.statuses:
        for event in status.events if state is not None else ():
            if event.kind is EventKind.STATE_CHANGED:
                assert event.old == state
                state = event.new
        state = status.ee if state is None else state
        assert status.ee == state


def test_the_way_of_a_goal_and_of_a_frame_is_short_and_nothing_is_worked_out_on_it(tool: Tool) -> None:
    """On the first visit of each state; the limits are a little above what it takes, so that a growth is seen."""
    goal = tool.lines.count = Count()
    assert tool.command("grip").accepted
    assert goal.reached.total() <= GOAL_CALLS, goal.reached.most_common()
    for _ in range(20):
        frame, count = tool.frame(), Count()
        tool.lines.count = count
        with count.counting():
            tool.program.frame(frame)
        tool.idle()
        if count.reached:
            break
    assert count.reached.total() <= FRAME_CALLS, count.reached.most_common()
    for calls in (goal.reached, count.reached):
        assert not [name for name in calls if name.startswith(("_semantics.py", "_trace.py", "_network"))]


GOAL_CALLS, FRAME_CALLS = 60, 66
"""From the call of the program to that of the line arbiter's client; `benchmarks/calls.py` counts both ends too."""


def test_the_readings_are_passed_on_after_each_frame_and_when_one_turns_stale(tool: Tool) -> None:
    shown: list[JudgedReadings] = []
    tool.program.on_readings = shown.append
    frame = tool.frame()
    tool.program.frame(frame)
    tool.idle()
    assert shown == [JudgedReadings(frame.at, dict(frame.values), tuple(sorted(frame.values)))]
    invalid = replace(tool.frame(), values={**QUIET, "bottom": None})
    tool.program.frame(invalid)
    assert (shown[-1].values["bottom"], "bottom" in shown[-1].sampled) == (None, False)
    tool.at += 150_000
    tool.idle()
    assert (shown[-1].at, set(shown[-1].values.values()), shown[-1].sampled) == (tool.at, {None}, ())
    assert len(shown) == 3


def test_a_trace_and_a_stream_are_handed_nothing_before_the_line_is_asked_for(tmp_path: Path) -> None:
    description = load(profile_path())
    recorder = open_recorder(tmp_path, description, stream=open_stream(description))
    tool = Tool(description, recorder)
    tool.run(60)
    goal = tool.lines.count = Count()
    assert tool.command("grip").accepted
    recorder.close()
    assert goal.reached["_recorded_controller.py:RecordedController.command"] == 1
    assert not [
        name
        for name in goal.reached
        if name.startswith(("_recorder.py", "_trace_writer.py", "_record_stream.py"))
    ]


def test_a_status_is_built_once_for_each_step_of_the_automata(
    tool: Tool, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[Status] = []
    build = StatusBuilder.status

    def counted(builder: StatusBuilder, at: int, events: tuple[ToolEvent, ...] = ()) -> Status:
        built.append(build(builder, at, events))
        return built[-1]

    monkeypatch.setattr(StatusBuilder, "status", counted)
    steps: list[object] = []
    step = StatusBuilder.step
    monkeypatch.setattr(StatusBuilder, "step", lambda *given: (steps.append(given[1]), step(*given))[1])
    monkeypatch.setattr(Foresight, "go_on", lambda _: False)  # it builds statuses that are not published
    tool.statuses.clear()
    tool.play("grip", 100)
    assert tool.program.status.ee is EndEffectorState.GRIPPED
    tool.play("drop", 100)
    assert tool.program.status.ee is EndEffectorState.STAND_BY
    assert len(steps) > 20
    published = [replace(each, begun=0, count=0) for each in tool.statuses]
    assert built == published  # what is not a step is news of the sensors: it is built once, too
    assert len(steps) <= len(built)


def test_nothing_is_begun_while_the_line_arbiter_is_away(tool: Tool) -> None:
    tool.lose()
    tool.idle()
    answer = tool.command("grip")
    assert not answer.accepted
    assert answer.reason == "Nothing can be activated while the line arbiter is lost."
    assert tool.program.status.ee is EndEffectorState.STAND_BY
    tool.lines.away = False
    tool.play(20, "grip", 100)
    status = tool.program.status
    assert status.ee is EndEffectorState.GRIPPED
    assert [report.attempts for report in status.steps] == [1, 1, 1]


@pytest.mark.parametrize(("waits_us", "accepted"), [(90_000, True), (110_000, False)])
def test_a_command_that_waited_for_longer_than_it_is_valid_is_not_executed(
    tool: Tool, waits_us: int, accepted: bool
) -> None:
    answer = tool.command("grip", until_us=tool.at + 100_000, waits_us=waits_us)
    assert answer.accepted is accepted
    assert ("too late" in answer.reason) is not accepted
    tool.run(100)
    assert (tool.program.status.ee is EndEffectorState.GRIPPED) is accepted


def test_a_client_of_the_stream_drives_one_actuator_under_the_lease(tool: Tool) -> None:
    def ask(word: str, actuator: str, valid_us: int = 1) -> Answer:
        message = ProgramCommand(1, tool.at + valid_us, word, actuator)
        return tool.ask(lambda: tool.program._asked(message))

    names = "bottom_vacuum, cylinder, top_vacuum"
    unknown = ask("activate", "bottom vacuum")
    assert (unknown.accepted, unknown.reason) == (
        False,
        f"There is no actuator called 'bottom vacuum'; there are {names}.",
    )
    assert "too late" in ask("activate", "cylinder", -1).reason
    assert not any(tool.lines.active.values())
    line = tool.description.actuators["cylinder"].line
    assert ask("activate", "cylinder").accepted
    assert tool.lines.active[line]
    assert tool.command("grip").reason.startswith("IL-12")
    tool.run(round(tool.description.maintenance.lease_s * 1e6 / PERIOD) - 10)
    assert tool.lines.active[line]
    tool.run(20)
    assert not any(tool.lines.active.values())
    tool.play(150, "grip", 100)
    assert ask("deactivate", "cylinder").reason.startswith("IL-12: a part is held")
    assert tool.lines.active[line]


@pytest.mark.parametrize("noticed", [True, False])
def test_a_drop_without_the_line_arbiter_ends_unreachable_and_is_not_carried_out_later(
    tool: Tool, noticed: bool
) -> None:
    tool.play("grip", 100)
    tool.lines.away = True
    if noticed:
        tool.program.arbiter_lost(ArbiterError("the line arbiter is away."))
        tool.idle()
    assert tool.command("drop") == Answer(
        False,
        "The line arbiter is lost: nothing was written, and nothing will be. Give the command again when it is back.",
        decided=False,
    )
    status = tool.program.status
    assert (status.ee, status.held, status.arbiter_lost) == (EndEffectorState.GRIPPED, True, True)
    assert all(status.outputs)
    tool.lines.away = False
    tool.run(400)
    assert all(gripping(tool))
    assert (tool.program.status.ee, tool.program.status.arbiter_lost) == (EndEffectorState.GRIPPED, False)
    tool.play("drop", 200)
    assert not any(tool.lines.active.values())


def test_an_unwinding_that_ends_without_the_line_arbiter_is_given_up(tool: Tool) -> None:
    """Its first line is written; what it could not write is not written after its end."""
    tool.play("grip", 100, "drop")
    left = dict(tool.lines.active)
    assert list(left.values()) == [True, True, False, False]
    tool.lose()
    tool.run(10)
    releasing = tool.program.status
    assert (releasing.ee, releasing.outputs) == (EndEffectorState.RELEASING, (True, True, False))
    tool.run(400)
    status = tool.program.status
    assert judge(Command.RELEASE, status) == (Outcome.UNREACHABLE, UNWRITTEN)
    assert status.outputs == (True, True, False)
    tool.lines.away = False
    tool.run(400)
    assert tool.lines.active == left
    assert (tool.program.status.ee, tool.program.status.held) == (EndEffectorState.GRIP_ERROR, True)


def test_maintenance_is_not_ended_by_a_command_that_the_line_arbiter_does_not_get(tool: Tool) -> None:
    line = tool.description.actuators["cylinder"].line
    drive = tool.program._drive
    assert tool.ask(lambda: drive("cylinder", None, active=True)).accepted
    tool.lines.away = True
    answer = tool.ask(lambda: drive("cylinder", None, active=False))
    assert (answer.accepted, answer.decided) == (False, False)
    assert tool.program.status.outputs == (False, True, False)
    tool.lines.away = False
    tool.run(100)
    assert tool.lines.active[line]
    assert tool.ask(lambda: drive("cylinder", None, active=False)).accepted
    assert not tool.lines.active[line]


def test_nothing_is_told_as_held_before_the_last_will_that_holds_it_has_arrived(tool: Tool) -> None:
    """Until then the arbiter would unwind it, should the program die."""
    assert tool.command("grip").accepted
    while not all(gripping(tool)):
        tool.run(1)
    tool.lose()
    tool.run(30)
    assert tool.program._adoption.controller.status().ee is EndEffectorState.GRIPPED
    tool.lines.active[tool.description.actuators["top_vacuum"].line] = False  # and its feedback goes
    tool.run(30)
    assert tool.program._adoption.controller.status().ee is EndEffectorState.GRIP_ERROR
    assert not any(status.held for status in tool.statuses)
    tool.lines.away = False
    tool.run(100)
    assert tool.program.status.ee is EndEffectorState.GRIP_ERROR
    assert tool.program.status.held


def test_the_events_of_what_was_withheld_come_with_what_is_published_next(tool: Tool) -> None:
    assert tool.command("grip").accepted
    while not all(gripping(tool)):
        tool.run(1)
    tool.lose()
    tool.run(30)
    assert tool.program._adoption.controller.status().ee is EndEffectorState.GRIPPED
    assert tool.program.status.ee is EndEffectorState.GRIPPING
    tool.lines.away = False
    tool.run(100)
    assert tool.program.status.held
    events = [event for status in tool.statuses for event in status.events]
    assert [event.actuator for event in events if event.kind is EventKind.CONFIRMED] == [0, 1, 2]
    assert [event.new for event in events if event.kind is EventKind.STATE_CHANGED][
        -1
    ] == tool.program.status.ee


def test_what_went_inactive_before_it_was_adopted_is_not_activated_again(tool: Tool) -> None:
    """The line arbiter was lost between the start and the first frames, and has executed a last will."""
    other = Tool(tool.description)
    other.lines.active |= {actuator.line: True for _, actuator in tool.description.ordered}
    other.program._act(other.program._restart("another restart"))  # finds them active
    other.program.arbiter_lost(ArbiterError("the line arbiter is away."))
    other.lines.active = dict.fromkeys(other.lines.active, False)
    other.run(400)
    assert not any(other.lines.active.values())
    assert other.program.status.ee is EndEffectorState.STAND_BY


def test_a_step_that_was_looked_ahead_at_is_the_one_that_is_taken() -> None:
    prepared, other = Tool(), Tool()
    other.idle = other.worker.work  # type: ignore[method-assign]
    for tool in (prepared, other):
        tool.play(60, "grip", 100, "drop", 100)
    assert prepared.statuses == other.statuses


def with_e_stop() -> Tool:
    shipped = load(profile_path())
    tool = Tool(shipped.model_copy(update={"e_stop": EStop()}))
    tool.run(60)
    return tool


UNREAD = Answer(
    False,
    "IL-13: the e-stop has no valid reading (estop_ok, sensor link /dev/verdin-uart1): "
    "nothing is activated until it has one.",
)


def without_e_stop(tool: Tool, frames: int) -> None:
    """Frames in which the channel of the e-stop has no valid value."""
    for _ in range(frames):
        frame = tool.frame()
        values = {**frame.values, "estop_ok": None}
        tool.program.frame(Frame(frame.at, tool._number, tool._number * 20, values))
        tool.idle()


def test_an_e_stop_that_is_not_read_refuses_a_grip_at_once_and_never_a_drop() -> None:
    tool = with_e_stop()
    without_e_stop(tool, 7)
    assert tool.program._obstacle("grip", tool.at) == "", "the last reading still counts"
    without_e_stop(tool, 1)
    before = len(tool.statuses)
    assert tool.command("grip") == UNREAD
    without_e_stop(tool, 20)
    assert not any(tool.lines.active.values())
    assert {status.ee for status in tool.statuses[before:]} <= {EndEffectorState.STAND_BY}
    # what the automata decide is as recorded: a grip that was accepted before this rule is accepted in a replay
    assert tool.program._adoption.controller.refusal("grip") == ""
    tool.run(1)
    assert tool.command("grip").accepted, "at once"
    tool.run(60)
    assert tool.program.status.ee is EndEffectorState.GRIPPED
    without_e_stop(tool, 20)
    assert tool.program.status.ee is EndEffectorState.GRIPPED
    assert tool.command("drop").accepted, "only activations are refused"


def test_a_silent_link_is_told_as_such_although_the_e_stop_is_on_it() -> None:
    tool = with_e_stop()
    tool.at += 150_000
    tool.idle()
    answer = tool.command("grip")
    assert not answer.accepted
    assert answer.reason.startswith("IL-07: ")
    assert tool.program.status.ee is EndEffectorState.STAND_BY


STOP = "IL-13: the tool was stopped (pid 7, eehal stop): nothing is activated until a reset."


@pytest.mark.parametrize(
    ("cancel", "ends"), [("release", EndEffectorState.STAND_BY), ("hold", EndEffectorState.GRIP_ERROR)]
)
def test_a_stop_cancels_a_grip_as_is_declared(cancel: str, ends: EndEffectorState) -> None:
    tool = Tool(declared({"gripping": {"cancel": cancel}}))
    tool.play(60, "grip", 2)
    assert tool.program.status.ee is EndEffectorState.GRIPPING
    before = dict(tool.lines.active)
    tool.latch({"stop": STOP})
    tool.run(40)
    status = tool.program.status
    assert (status.ee, status.cause) == (ends, Cause.CANCELLED)
    assert STOP in status.alarm_texts
    assert (tool.lines.active == before) is (cancel == "hold")


def test_a_stop_holds_what_is_held_and_refuses_a_grip_until_a_reset(tool: Tool) -> None:
    tool.latch({"stop": STOP})
    assert tool.command("grip") == Answer(False, STOP)
    tool.latch({})
    tool.play("grip", 60)
    assert tool.program.status.ee is EndEffectorState.GRIPPED
    before = dict(tool.lines.active)
    tool.latch({"stop": STOP})
    tool.run(40)
    assert tool.program.status.ee is EndEffectorState.GRIPPED
    assert tool.lines.active == before
    assert tool.command("drop").accepted, "a stop refuses activations only"


def test_an_open_e_stop_refuses_a_grip_at_once_until_a_reset_and_cancels_nothing(tool: Tool) -> None:
    opened = "IL-13: the emergency stop was opened."
    tool.run(60)
    tool.latch({"e_stop_closed": opened})
    refused = Answer(False, f"{opened} Nothing is activated until it is closed and the faults are reset.")
    assert tool.command("grip") == refused
    assert tool.program.status.ee is EndEffectorState.STAND_BY
    tool.latch({})
    tool.play("grip", 2)
    tool.latch({"e_stop_closed": opened})
    assert tool.program.status.ee is EndEffectorState.GRIPPING, "only the next activation is refused"


def test_an_e_stop_that_opens_before_the_lines_are_adopted_is_told_to_the_line_arbiter() -> None:
    """The line arbiter latches it; what the sensors prove is told of adopted lines only."""
    description, now = load(profile_path()).model_copy(update={"e_stop": EStop()}), 0
    told: list[tuple[int, Mapping[str, bool]]] = []

    class Sender:
        def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
            told.append((at_us, predicates))
            return True

        def close(self) -> None:
            """Nothing is open."""

    lines = Lines(description)
    lines.away = True
    publisher = PredicatePublisher(description, lambda: now, Sender(), own=False)
    program = Program(description, lines, clock=lambda: now, publisher=publisher, worker=InlineWorker)
    program.begin()
    for closed in (True, False, True):
        now += PERIOD
        program.frame(Frame(now, None, None, {**QUIET, "estop_ok": closed}))
    assert told == [(2 * PERIOD, {"e_stop_closed": False})]


@pytest.mark.parametrize(
    ("command", "line", "channel"),
    [("grip", "SODIMM_208", "grip_refused"), ("unlock", "SODIMM_206", "unlock_refused")],
)
def test_a_refused_write_reaches_the_channel_and_the_reason_of_its_line(
    command: str, line: str, channel: str
) -> None:
    events: list[Any] = []
    tool = Tool(
        recorder=Recorder(observe=lambda kind, _, what: events.append(what) if kind == "event" else None)
    )
    tool.run(60)
    tool.lines.refused = line
    assert tool.command(command).accepted
    tool.run(60)
    assert [event.channel for event in events if event.channel.endswith("_refused")] == [channel]
    status = tool.program.status
    assert (status.ee, status.changer) == (EndEffectorState.STAND_BY, ChangerState.LOCKED)
    told = REFUSED in status.reason, REFUSED in status.changer_reason
    assert told == (command == "grip", command == "unlock")
    tool.lines.refused = ""
    assert tool.command("unlock" if command == "grip" else "grip").accepted
    status = tool.program.status
    assert told == (REFUSED in status.reason, REFUSED in status.changer_reason), "of another command"


def test_the_sensor_fault_is_latched_with_its_reason_and_cleared_by_a_reset(tool: Tool) -> None:
    frame = tool.frame
    both = {"locked": True, "unlocked": True}
    tool.frame = lambda: replace(told := frame(), values={**told.values, **both})  # type: ignore[method-assign]
    tool.run(40)
    assert tool.program.status.changer is ChangerState.FAULT
    assert tool.lines.faults == {SENSOR_FAULT: tool.program.status.changer_reason}
    assert tool.lines.faults[SENSOR_FAULT].startswith("IL-04: ")
    tool.frame = frame  # type: ignore[method-assign]
    tool.play(10, "reset", 10)
    assert tool.lines.faults == {}


def test_a_lock_that_waits_for_its_line_is_told_at_once(tool: Tool) -> None:
    """A line may have to settle (IL-10), a coil to rest: what is at rest meanwhile is not withheld, for it is known."""
    tool.play("unlock", 20)
    assert tool.program.status.changer is ChangerState.UNLOCKED
    tool.lines.delay_us = 100_000
    assert tool.command("lock").accepted
    status = tool.program.status
    assert (status.ee, status.changer) == (EndEffectorState.STAND_BY, ChangerState.LOCKING)
    assert status.command is Command.LOCK


def test_a_release_is_told_when_its_line_has_settled(tool: Tool) -> None:
    tool.play("grip", 100)
    tool.lines.delay_us = 100_000
    tool.play("drop", 200)
    assert tool.program._adoption.controller.status().ee is EndEffectorState.STAND_BY
    assert tool.program.status.ee is EndEffectorState.RELEASING
    tool.lines.delay_us = 0
    tool.run(20)
    assert tool.program.status.ee is EndEffectorState.STAND_BY
