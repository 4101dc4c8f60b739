"""The same core without ROS: the tool in this process, with real owner and testbench processes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from end_effector_hal.control import Status
from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import Recording
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._scenario import DemoScenario, Order
from ._world import World

READY_S = 10.0


class _Recorder:
    """Hands what the tool says to the recording."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def status(self, status: Status) -> None:
        self._recording.state(status.at, status.ee, status.command, status.actuators)
        self._recording.alarms(status.at, status.alarms)

    def frame(self, frame: Frame) -> None:
        self._recording.values(frame.at, frame.values)


def play_core(scenario: DemoScenario, world: World, folder: Path) -> None:
    """Play a scenario through `EndEffector`, recorded into ``folder``; ``tool.log`` tells what was answered.

    Raises:
        ReportedError: the tool cannot be opened, or does not get ready.
    """
    with (
        (folder / "tool.log").open("w", encoding="utf-8", buffering=1) as log,
        Recording(folder, world.description, scenario=scenario.bench) as recording,
    ):
        recorder = _Recorder(recording)
        recording.state(now_us(), 0, Command.NONE, [0] * len(world.description.sequence))
        tool = EndEffector(world.description, traces=folder)
        tool.subscribe(recorder.status)
        tool.subscribe_frames(recorder.frame)
        with tool:
            tool.start()
            tool.wait_ready(READY_S)
            play = _Play(tool, lambda text: print(text, file=log), scenario.longest_s(world.description))
            time.sleep(scenario.rest_s)
            for order in scenario.orders:
                play.give(order)
                time.sleep(order.wait_s)
            play.finish()


class _Play:
    """Gives orders to a tool and writes down what became of them.

    Each runs in a thread of its own, so that a tool that never answers does not hold the demo for ever.
    """

    def __init__(self, tool: EndEffector, say: Callable[[str], None], longest_s: float) -> None:
        self._tool, self._say, self._longest_s = tool, say, longest_s
        self._running: list[threading.Thread] = []

    def give(self, order: Order) -> None:
        """Give an order, and wait for its outcome if it is not in the background."""
        if order.arm:
            answer = self._tool.arm()
            self._say(f"arm: {'accepted' if answer.accepted else answer.reason}")
        if order.command is Command.CANCEL:
            answer = self._tool.cancel()
            self._say(f"cancel: {'accepted' if answer.accepted else answer.reason}")
        else:
            name = order.command.name.lower()
            self._running.append(threading.Thread(target=self._run, args=(name,), name=name, daemon=True))
            self._running[-1].start()
        if not order.background:
            self.finish()

    def finish(self) -> None:
        """Wait for what runs; raises ReportedError when it does not end."""
        for thread in self._running:
            thread.join(self._longest_s)
            if thread.is_alive():
                raise ReportedError(f"The {thread.name} was not over after {self._longest_s:g} s.")
        self._running.clear()

    def _run(self, name: str) -> None:
        tool = self._tool
        outcome = {"lock": tool.lock, "unlock": tool.unlock, "grip": tool.grip, "release": tool.drop}[name]()
        done = "succeeded" if outcome.succeeded else "failed"
        self._say(f"{name}: {done}, {outcome.state.name} {outcome.reason}".rstrip())
