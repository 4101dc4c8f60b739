"""One tool in virtual time: commands and faults at random moments, from one seed."""

from __future__ import annotations

import traceback
from collections import Counter
from dataclasses import dataclass, field
from random import Random

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState
from end_effector_lab.testbench import Sent
from tests.acceptance.link_campaign.faults import KINDS, NOMINAL, LinkFault, plant, together
from tests.acceptance.link_campaign.judge import Judge, undetected
from tests.support.virtual_tool import VirtualTool
from timed_automata import Network

FUNCTIONS = ("rest", "grip", "hold", "drop", "cancel", "lock", "unlock")
Cell = tuple[str, str]


@dataclass
class Found:
    """What one episode, or many, have shown; counted by kind of fault and function that it hit."""

    faults: Counter[Cell] = field(default_factory=Counter)
    decoded: int = 0
    refused: int = 0
    undetected: int = 0
    confirmations: int = 0
    false_confirmations: int = 0
    gripped: int = 0
    tracebacks: list[str] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)

    def add(self, other: Found) -> None:
        """Put another one's to it."""
        self.faults += other.faults
        for name in ("decoded", "refused", "undetected", "confirmations", "false_confirmations", "gripped"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.tracebacks += other.tracebacks
        self.violations += other.violations


class Watched(VirtualTool):
    """A virtual tool with a judge."""

    def __init__(self, description: Description, network: Network, seed: int, scenario: str) -> None:
        self.judge: Judge | None = None
        self.found = Found()
        self._sent: dict[int, dict[str, object]] = {}
        super().__init__(description, scenario, network=network, seed=seed)
        self.judge = Judge(description, self.bench)

    def order(self, name: str) -> None:
        """Give a command; what it brings about at once is judged as what follows a command that was taken."""
        assert self.judge
        before = self.judge.asked(name)
        answer = self.command(name)
        self.judge.answered(name, answer, before, self.at)

    def _heard(self, sent: Sent, frames: list[Frame]) -> None:
        if self.judge is None:
            return
        self.judge.oracle.look(self.at)
        self.judge.claims(self.at)
        clean = self.codec.decoder().feed(sent.clean, self.at)
        if sent.seq == 0:
            self._sent.clear()
        for frame in clean:
            self._sent[sent.seq] = dict(frame.values)
        self.found.decoded += len(frames)
        self.found.undetected += sum(undetected(self._sent, frame.seq, frame.values) for frame in frames)

    def _told(self, statuses: list[Status]) -> None:
        if self.judge:
            for status in statuses:
                self.judge.status(status)
        super()._told(statuses)

    def _write(self, wanted, at):  # type: ignore[no-untyped-def]
        count = len(self.edges)
        super()._write(wanted, at)
        if self.judge:
            for when, line, level in self.edges[count:]:
                self.judge.edge(line, level, when)


class Episode:
    """Plays ``faults`` faults on one tool, then expects it to be usable without any repair."""

    def __init__(self, description: Description, network: Network, seed: int, faults: int) -> None:
        self._random = Random(seed)
        self._seed, self._left = seed, faults
        self._plant = plant(self._random)
        self._tool = Watched(description, network, seed, self._plant)
        self._fault: LinkFault | None = None

    def play(self) -> Found:
        """Everything; a traceback is a finding too."""
        tool = self._tool
        try:
            tool.run(self._random.uniform(0.5, 1.2))
            while self._left:
                self._command()
                self._disturb()
            self._recover()
        except Exception:  # noqa: BLE001 whatever it is, it must not have happened
            tool.found.tracebacks.append(f"seed {self._seed}: {traceback.format_exc()}")
        judge, found = tool.judge, tool.found
        assert judge
        found.refused = sum(tool.decoder.errors.values())
        found.confirmations, found.false_confirmations = judge.confirmations, judge.false_confirmations
        found.violations = [f"seed {self._seed}, {text}" for text in judge.violations]
        return found

    @property
    def function(self) -> str:
        """What the tool is doing."""
        status = self._tool.status
        if status.command in (Command.LOCK, Command.UNLOCK):
            return "lock" if status.command == Command.LOCK else "unlock"
        if status.ee == EndEffectorState.RELEASING:
            return "cancel" if status.command == Command.CANCEL else "drop"
        if status.ee == EndEffectorState.GRIPPING:
            return "grip"
        return "hold" if status.held else "rest"

    def _command(self) -> None:
        """What an operator would do next, now and then what he would not."""
        tool, random = self._tool, self._random
        unlocked = tool.status.changer in (ChangerState.UNLOCKED, ChangerState.FAULT)
        likely = {
            "rest": "lock" if unlocked else random.choice(("grip", "grip", "grip", "unlock")),
            "grip": random.choice(("", "", "", "cancel")),
            "hold": random.choice(("", "", "drop")),
        }.get(self.function, random.choice(("", "lock")))
        if tool.status.ee == EndEffectorState.RELEASE_ERROR:
            likely = "drop"
        if random.random() < 0.05:
            likely = random.choice(("grip", "drop", "cancel", "lock", "unlock"))
        if likely:
            tool.order(likely)

    def _disturb(self) -> None:
        tool, random = self._tool, self._random
        tool.run(random.choice((0.0, random.uniform(0, 0.2), random.uniform(0, 1.5))))
        fault = KINDS[random.choice(list(KINDS))](random)
        self._left -= 1
        tool.found.faults[fault.kind, self.function] += 1
        assert tool.judge
        tool.judge.fault(fault, tool.at)
        gripped = tool.status.ee == EndEffectorState.GRIPPED
        tool.bench.choose(together(self._plant, fault.scenario), tool.at)
        half = fault.seconds * random.random()
        tool.run(half)
        if random.random() < 0.5:
            self._command()
        tool.run(fault.seconds - half)
        tool.bench.choose(self._plant, tool.at)
        tool.run(random.choice((0.02, random.uniform(0.05, 0.5))))
        tool.found.gripped += gripped

    def _recover(self) -> None:
        """A good link and good devices again: what an operator does then must be enough."""
        tool = self._tool
        tool.bench.choose(NOMINAL, tool.at)
        for _ in range(30):
            tool.run(2.0)
            status = tool.status
            if status.held or status.ee in (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR):
                tool.order("drop")
            elif status.command == Command.NONE and status.changer != ChangerState.LOCKED:
                tool.order("lock")
            elif status.ee == EndEffectorState.STAND_BY and status.command == Command.NONE:
                break
        tool.run(11.0)  # so long a reboot is told
        status, judge = tool.status, tool.judge
        assert judge
        if status.ee != EndEffectorState.STAND_BY or status.alarm_texts:
            state = EndEffectorState(status.ee).name
            judge.violations.append(
                f"{status.at / 1e6:.3f} s: not usable again: {state}, {status.alarm_texts}"
            )
