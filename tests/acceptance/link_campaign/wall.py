"""The same in real time: link reader, program, line arbiter and testbench as they are, over a pty and virtual lines."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from random import Random
from tempfile import mkdtemp

from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import ArbiterError, NotReadyError, ReportedError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import ChipWatcher, Edge
from end_effector_lab.demo._world import START_S, World
from end_effector_lab.processes import EEHAL
from end_effector_lab.testbench import Testbench
from end_effector_lab.testbench._ports import PtyPort
from end_effector_lab.testbench._testbench import Watcher
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.acceptance.link_campaign.episode import Found
from tests.acceptance.link_campaign.faults import KINDS, NOMINAL
from tests.acceptance.link_campaign.judge import Judge

LATE_US = 1_000_000
LONGEST_S = 2.0
# What is wrong with the bytes only: then the testbench's sensors tell the truth.
WIRE = ("bit flips", "bursts", "changed bytes", "lost bytes", "doubled bytes", "silence", "babble", "reboot")


class Hardware(World, Watcher):
    """Line arbiter and chip as in a demo; the testbench in this process, so that the judge sees how it really is."""

    def __init__(self, description: Description, folder: Path) -> None:
        super().__init__(description, NOMINAL, folder)
        self.judge: Judge | None = None
        self.lock = threading.RLock()
        self.error: ReportedError | None = None

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        if self.judge:
            with self.lock:
                self.judge.oracle.look(at)
                self.judge.claims(at)

    def failed(self, error: ReportedError) -> None:
        self.error = error

    def _start(self) -> None:
        changer = self.description.tool_changer
        lines = [actuator.line for _, actuator in self.description.ordered] + (
            [changer.line] if changer else []
        )
        self.bench = Testbench(
            self.description, VirtualInputs(self.chip, lines), PtyPort(str(self.port)), watcher=self
        )
        self.bench.start()
        self.judge = Judge(self.description, self.bench._bench, late_us=LATE_US)
        path = str(self.description_path)
        arbiter = self.children.start(
            "line arbiter", [*EEHAL, "arbiter", path], log=self.folder / "arbiter.log", failed=ArbiterError
        )
        arbiter.wait_until(self.socket.exists, timeout_s=START_S, what="its socket")

    def _end(self) -> None:
        self.bench.close()
        super()._end()


class Run:
    """A tool, an operator in a thread of his own, and faults in this one."""

    def __init__(self, hardware: Hardware, tool: EndEffector, seed: int) -> None:
        assert hardware.judge
        self._hardware, self._tool, self._judge = hardware, tool, hardware.judge
        self._random, self._hands = Random(seed), Random(seed + 1)
        self._lock, self._ended = hardware.lock, threading.Event()
        self.found = Found()

    def play(self, seconds: float) -> Found:
        """Faults for so long, then what an operator does must be enough."""
        tool, random, bench = self._tool, self._random, self._hardware.bench
        tool.subscribe(self._status)
        operator = threading.Thread(target=self._operate, name="operator")
        operator.start()
        end = time.monotonic() + seconds
        try:
            while time.monotonic() < end:
                fault = KINDS[random.choice(WIRE)](random)
                self.found.faults[fault.kind, self._function()] += 1
                bench.choose(fault.scenario)
                time.sleep(min(fault.seconds, LONGEST_S))
                bench.choose(NOMINAL)
                time.sleep(random.uniform(0.02, 0.6))
                if random.random() < 0.1:
                    self._give("cancel")
        finally:
            bench.choose(NOMINAL)
            self._ended.set()
            operator.join(90)
        self._recover()
        return self._result()

    def _operate(self) -> None:
        try:
            while not self._ended.is_set():
                self._next()
                self._ended.wait(self._hands.uniform(0, 1.0))
        except Exception:  # noqa: BLE001 whatever it is, it must not have happened
            self.found.tracebacks.append(traceback.format_exc())

    def _next(self) -> None:
        status, hands = self._tool.status, self._hands
        if status.held or status.ee in (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR):
            self._give("drop")
        elif status.changer != ChangerState.LOCKED:
            self._give("lock")
        else:
            self._give(hands.choice(("grip", "grip", "grip", "unlock")))

    def _give(self, name: str) -> None:
        with self._lock:
            before = self._judge.asked(name)
        result = getattr(self._tool, name)()
        if isinstance(result, Answer):
            answer = result
        else:
            # a drop that was refused leaves what was held
            taken = name != "drop" or not self._tool.status.held
            answer = Answer(taken and (result.succeeded or bool(result.reason)), result.reason)
        with self._lock:
            self._judge.answered(name, answer, before, now_us())

    def _recover(self) -> None:
        for _ in range(20):
            time.sleep(0.5)
            status = self._tool.status
            if status.ee == EndEffectorState.STAND_BY and status.changer == ChangerState.LOCKED:
                return
            self._next()
        self._judge.violations.append(f"not usable again: {self._tool!r}, {self._tool.status.alarm_texts}")

    def _result(self) -> Found:
        health, found = self._tool.link, self.found
        found.decoded, found.refused = health.frames, sum(health.errors.values())
        found.confirmations = self._judge.confirmations
        found.false_confirmations = self._judge.false_confirmations
        found.violations = [f"wall clock, {text}" for text in self._judge.violations]
        if self._hardware.error:
            found.tracebacks.append(str(self._hardware.error))
        return found

    def _status(self, status: Status) -> None:
        with self._lock:
            self._judge.status(status)

    def edge(self, edge: Edge) -> None:
        """A line was written."""
        with self._lock:
            self._judge.edge(edge.line, edge.level, edge.at)

    def _function(self) -> str:
        status = self._tool.status
        if status.command in (Command.LOCK, Command.UNLOCK):
            return "lock" if status.command == Command.LOCK else "unlock"
        if status.ee == EndEffectorState.RELEASING:
            return "cancel" if status.command == Command.CANCEL else "drop"
        if status.ee == EndEffectorState.GRIPPING:
            return "grip"
        return "hold" if status.held else "rest"


@contextmanager
def _watched(path: Path, run: Run) -> Iterator[None]:
    watcher = ChipWatcher(path, run.edge)
    watcher.start()
    try:
        yield
    finally:
        watcher.close()


def play_for(seconds: float, seed: int) -> Found:
    """Everything is started, disturbed, and ended."""
    folder = Path(mkdtemp(prefix="eehal-link-"))
    with Hardware(load(profile_path()), folder) as hardware, EndEffector.open(hardware.description) as tool:
        try:
            tool.wait_ready(20)
        except NotReadyError as error:
            return Found(violations=[f"wall clock: {error}"])
        run = Run(hardware, tool, seed)
        with _watched(hardware.chip, run):
            return run.play(seconds)
