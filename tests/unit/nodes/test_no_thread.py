"""A thread that the system does not give is a command that is refused, with a reason; the next one may succeed."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.nodes.transport import Commander
from end_effector_hal.runtime.stream import RecordStream
from end_effector_hal.wires.sensors import SensorHealth

NO_THREAD = RuntimeError("can't start new thread")


class Connection:
    def call(self, command: int, until_us: int) -> Answer:
        return Answer(True)

    def close(self) -> None:
        pass


def start_nothing(_: threading.Thread) -> None:
    raise NO_THREAD


def test_a_command_to_a_node_is_refused_and_the_next_one_is_given() -> None:
    commander = Commander("Grip", Connection)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threading.Thread, "start", start_nothing)
        assert commander.ask(2) == Answer(False, f"The node Grip cannot be asked: {NO_THREAD}.")
    assert commander.ask(2).accepted


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
