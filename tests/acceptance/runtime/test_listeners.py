"""A listener of the Python API that raises, blocks or asks the tool something: the tool works, and says it."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime import EndEffector, Program
from end_effector_hal.runtime.tool import _listeners
from end_effector_hal.runtime.tool._listeners import Listening
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_lab.demo._world import World
from tests.support.lone_program import CYLINDER, LINES, OFF, TOP, Tool
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]


class Ear:
    """A listener that does what a test says."""

    def __init__(self) -> None:
        self.heard: list[int] = []
        self.error: BaseException | None = None
        self.goes_on = threading.Event()
        self.goes_on.set()

    def __call__(self, item: int) -> None:
        self.goes_on.wait()
        if self.error is not None:
            raise self.error
        self.heard.append(item)


@pytest.fixture
def ear() -> Iterator[Ear]:
    made = Ear()
    yield made
    made.goes_on.set()


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (KeyError("x"), "KeyError: 'x'"),
        (SystemExit(3), "SystemExit: 3"),
        (ReportedError("No row.", where="here"), "here: No row."),
        (ValueError("\udcff\n" + "x" * 1000), f"ValueError: ? {'x' * 286}"),
    ],
)
def test_what_it_raises_is_an_alarm_until_it_works_and_somebody_has_seen_it(
    ear: Ear, error: BaseException, words: str
) -> None:
    changes: list[None] = []
    listening = Listening(ear, "that shows", lambda: changes.append(None))
    ear.error = error
    for number in range(5):
        listening.put(number)
    wait_until("an alarm", lambda: listening.alarm)
    text = f"The listener that shows failed: {words}"
    assert str(listening.alarm) == text
    listening.acknowledge()
    assert str(listening.alarm) == text
    wait_until("all five", lambda: not listening._waiting and listening._called_at is None)
    ear.error = None
    listening.put(6)
    wait_until("it works", lambda: str(listening.alarm) == f"Over: {text}")
    wait_until("both", lambda: len(changes) == 2)
    listening.acknowledge()
    assert listening.alarm is None
    listening.close(time.monotonic() + PATIENCE_S)
    assert ear.heard == [6]


def test_one_that_blocks_delays_nobody_and_gets_the_newest(ear: Ear, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_listeners, "MOST_WAITING", 10)
    listening = Listening(ear, "", lambda: None)
    ear.goes_on.clear()
    listening.put(0)
    wait_until("it is called", lambda: listening._called_at is not None)
    for number in range(1, 31):
        listening.put(number)
    text = "The listener Ear is too slow for its calls."
    assert str(listening.alarm) == text
    ear.goes_on.set()
    wait_until("it works", lambda: len(ear.heard) == 11)
    assert ear.heard == [0, *range(21, 31)]
    wait_until("it is over", lambda: str(listening.alarm) == f"Over: {text} 20 were dropped.")


def test_one_that_does_not_return_is_an_alarm_without_any_further_call(
    ear: Ear, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_listeners, "SLOW_US", 0)
    listening = Listening(ear, "", lambda: None)
    ear.goes_on.clear()
    listening.put(0)
    wait_until("an alarm", lambda: "is too slow for its calls" in str(listening.alarm))
    listening.close(0.0)  # returns all the same


def test_an_item_with_the_key_of_the_one_before_is_skipped_unless_the_key_fails(ear: Ear) -> None:
    listening = Listening(ear, "", lambda: None, lambda number: 12 // number)
    for number in (12, 7, 6, 12, 0, 0, 12):
        listening.put(number)
    listening.close(time.monotonic() + PATIENCE_S)
    assert ear.heard == [12, 6, 12, 0, 0, 12]


def test_a_listener_of_a_program_that_raises_does_not_end_it() -> None:
    """As a node's, or EndEffector's own."""
    tool = Tool()
    told: list[Status] = []

    def fails(status: Status) -> None:
        told.append(status)
        if status.ee == State.GRIPPING:
            sys.exit(1)
        if status.ee == State.GRIPPED:
            raise OSError(28, "No space left on device")

    tool.program = Program(load(profile_path()), tool.arbiter, fails)
    tool.program.start()
    tool.grip_to(2)
    tool.until(lambda status: "A listener failed and missed a status: SystemExit: 1" in status.alarm_texts)
    tool.confirmed[TOP] = True
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.until(
        lambda status: any("OSError" in alarm or "SystemExit" in alarm for alarm in status.alarm_texts)
    )
    assert tool.program.alive
    assert tool.program.command("drop").accepted
    tool.until(lambda _: not tool.arbiter.active[TOP])
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: status.ee == State.STAND_BY and not status.alarm_texts)
    assert State.GRIPPED in [status.ee for status in told]
    assert tool.arbiter.active[CYLINDER] is False
    tool.program.close()


def test_a_tool_whose_listeners_raise_and_block_grips_and_drops(world: World) -> None:
    blocked = threading.Event()

    def raises(_: object) -> None:
        raise RuntimeError("third party")

    def blocks(_: object) -> None:
        blocked.wait()

    with EndEffector.open(world.description) as tool:
        told: list[Status] = []
        tool.subscribe(raises)
        tool.subscribe(blocks)
        tool.subscribe(told.append)
        tool.subscribe_frames(raises)
        tool.subscribe_frames(blocks)
        asked: list[Any] = []
        tool.subscribe(lambda _: asked.append(tool.status.alarm_texts))
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.lock().succeeded)
        assert tool.grip().succeeded
        alarms = wait_until(
            "both alarms", lambda: len(tool.status.alarm_texts) == 2 and tool.status.alarm_texts
        )
        assert sorted(alarm.partition(">.")[2] for alarm in alarms) == [
            "blocks is too slow for its calls.",
            "raises failed: RuntimeError: third party",
        ]
        wait_until("the listeners know it", lambda: told[-1].alarm_texts == alarms)
        assert tool.drop().succeeded
        wait_until("the last state", lambda: told[-1].ee == State.STAND_BY)
        assert asked
        blocked.set()
        # it listens to statuses and to frames, and catches up with one of them first
        wait_until(
            "both are over",
            lambda: sorted(alarm.startswith("Over: ") for alarm in tool.status.alarm_texts) == [False, True],
        )
        tool.reset()
        wait_until("the other stays", lambda: len(tool.status.alarm_texts) == 1)


def test_a_grip_whose_program_ends_says_so(world: World) -> None:
    """It was False without a reason: whoever asked took a part that is held for one that is not."""
    world.choose("never-confirms:top_vacuum")
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        outcomes: list[Any] = []
        asking = threading.Thread(target=lambda: outcomes.append(tool.grip()))
        wait_until("it", lambda: tool.lock().succeeded)
        asking.start()
        wait_until("gripping", lambda: tool.status.ee == State.GRIPPING)
        tool._program._latest.end()
        asking.join(60)
        assert not outcomes[0].succeeded
        assert outcomes[0].reason.startswith(
            "The HAL has gone: it is unknown whether the command was executed"
        )
