"""A thread that the system does not give is a command that is refused, with a reason; the next one may succeed."""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Outcome
from end_effector_hal.nodes._hal_main import HalMainNode
from end_effector_hal.nodes.interface import TRIGGER_GRIP
from end_effector_hal.runtime.stream import RecordStream
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.lone_node import LoneTransport
from tests.support.patience import wait_until

NO_THREAD = RuntimeError("can't start new thread")


def start_nothing(_: threading.Thread) -> None:
    raise NO_THREAD


def test_a_goal_is_refused_and_the_next_one_is_given() -> None:
    transport, ended = LoneTransport(), list[tuple[Outcome, str]]()
    HalMainNode(cast("Any", transport))
    goal = SimpleNamespace(
        request=SimpleNamespace(part=""), end=lambda ending, _: ended.append((ending.outcome, ending.reason))
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threading.Thread, "start", start_nothing)
        transport.goals[TRIGGER_GRIP.name](goal)
    assert ended == [(Outcome.REJECTED, f"The HAL cannot be asked: {NO_THREAD}.")]
    transport.goals[TRIGGER_GRIP.name](goal)
    wait_until("it is asked", lambda: transport.hal.asked == ["grip"])


@pytest.mark.parametrize("left", [0, 1])
def test_a_program_goes_on_without_its_stream(tmp_path: Path, left: int) -> None:
    real, started = threading.Thread.start, []

    def start(thread: threading.Thread) -> None:
        started.append(thread)
        if len(started) > left:
            raise NO_THREAD
        real(thread)

    stream = RecordStream(tmp_path / "stream", tmp_path, lambda _: {}, ())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threading.Thread, "start", start)
        stream.serve(lambda _: Answer(True), lambda: True, lambda: None, lambda: SensorHealth({}, None))
    stream.put([("state", 0, {})])
    stream.close()
    assert not (tmp_path / "stream").exists()
