"""What the line arbiter does in virtual time, as a question to the model checker: is it a run of its template?"""

from __future__ import annotations

import random
import re
from dataclasses import dataclass, field

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.control import GripLastWill, Status, model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.vocabulary import Command, EndEffectorState, LastWillStep
from tests.support.seen import SeenStep, seen
from timed_automata import make_network, read_document
from timed_automata.explore import Explorer

MS = 1000
_KEPT = re.compile(r"\t<template>\s*<name[^>]*>(?:Arbiter|Blower|Wills)</name>.*?</template>\n", re.DOTALL)
_STATES = (
    (EndEffectorState.GRIPPING, Command.GRIP),
    (EndEffectorState.GRIPPED, Command.NONE),
    (EndEffectorState.RELEASING, Command.RELEASE),
    (EndEffectorState.GRIP_ERROR, Command.NONE),
    (EndEffectorState.GRIP_ERROR, Command.RELEASE),
)


class Lines:
    """A back-end that does what it is told."""

    def __init__(self) -> None:
        self.levels: dict[str, bool] = {}

    def request(self, lines: list[str]) -> dict[str, bool]:
        self.levels = dict.fromkeys(lines, False)
        return dict(self.levels)

    def set(self, levels: dict[str, bool]) -> None:
        self.levels |= levels


@dataclass
class Run:
    """A rules with its two clients, and the steps of a process that has seen the same."""

    description: Description
    policy: Policy
    arbiter_type: type[LineArbiter] = LineArbiter
    left: tuple[str, ...] = ()
    """Lines that an unwinding leaves active."""
    steps: list[SeenStep] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.lines, self.at = Lines(), 0
        self.rules = self.arbiter_type(self.lines, self.policy, 0)
        self.names = [part.line for _, part in self.description.ordered]
        assert self.description.tool_changer
        self.unlock = self.description.tool_changer.line
        self.blow_offs = {
            each.line: self.description.sequence.index(name)
            for name, each in self.description.blow_offs.items()
        }
        self.blowing: set[str] = set()
        self.state = _STATES[0]
        self.grip = self.rules.hello("grip", "a" * 32, [*self.names, *self.blow_offs], (), 0)
        self.change = self.rules.hello("tool_change", "b" * 32, [self.unlock], (), 0)
        self.valve = dict.fromkeys(self.names, False)
        self.steps.append((0, {"assignment": "world = APART, changer = LOCKED, ee = STAND_BY"}))

    def to(self, at: int) -> None:
        """Time passes, in ms; each change of a line is seen just before and just after it."""
        while (due := self.rules.deadline) is not None and due <= at * MS:
            self._renew(due)
            before = self._seen()
            self.rules.advance(due)
            if self._seen() != before:
                moment = -(-due // MS)
                self.steps += [(moment - 1, {"guard": before}), (moment, {"guard": self._seen()})]
        self._renew(at * MS)
        self.rules.advance(at * MS)
        self.at = at

    def grips(self, state: tuple[EndEffectorState, Command], line: str, level: bool) -> None:
        """Grip writes one line, with the will that control computes for its state."""
        self.valve[line], self.state = level, state
        ee, command = state
        status = self._status(state)
        index = self.names.index(line)
        try:
            self.rules.write(
                self.grip, {line: level}, GripLastWill(self.description).of(status), self.at * MS
            )
        except LineRefusedError:
            self.valve[line] = False
        told = f"ee = {int(ee)}, command = {int(command)}, valve[{index}] = {str(self.valve[line]).lower()}"
        told += "".join(f", kept[{at}] = {str(at in status.kept).lower()}" for at in range(len(self.names)))
        channel = "activate" if level else "deactivate"
        self._step({"synchronisation": f"{channel}[{index}]!", "assignment": told})
        self._look()

    def blows(self, line: str, level: bool) -> None:
        """Grip begins to blow something off, or ends it."""
        self.blowing = self.blowing | {line} if level else self.blowing - {line}
        will = GripLastWill(self.description).of(self._status(self.state))
        try:
            self.rules.write(self.grip, {line: level}, will, self.at * MS)
        except LineRefusedError:
            self.blowing.discard(line)
        index = self.blow_offs[line]
        told = f"blow[{index}] = {str(line in self.blowing).lower()}"
        self._step({"synchronisation": f"blow_{'on' if level else 'off'}[{index}]!", "assignment": told})
        self._look()

    def _status(self, state: tuple[EndEffectorState, Command]) -> Status:
        ee, command = state
        outputs = tuple(self.valve.values())
        latched = ee is EndEffectorState.GRIP_ERROR and command is Command.NONE
        held = ee is EndEffectorState.GRIPPED or (latched and any(outputs))
        left = self.left if ee is EndEffectorState.RELEASING else ()
        kept = tuple(self.names.index(each) for each in left if self.valve[each])
        blowing = tuple(self.blow_offs[line] for line in sorted(self.blowing))
        idle = (0,) * len(outputs)
        return Status(
            self.at, int(ee), int(command), idle, outputs, (), held=held, kept=kept, blowing=blowing
        )

    def unlocks(self, level: bool) -> None:
        """ToolChange writes its line."""
        changer = self.description.tool_changer
        locks = changer is not None and changer.endings.process_death == "release"
        will = (LastWillStep(self.unlock),) if level and locks else ()
        try:
            self.rules.write(self.change, {self.unlock: level}, will, self.at * MS)
        except LineRefusedError:
            level = False
        told = f"unlock_valve = {str(level).lower()}"
        self._step({"synchronisation": "open!" if level else "close!", "assignment": told})
        self._look()

    def dies(self, session: object) -> None:
        """A client dies, and the arbiter sees it at once."""
        self._step({})
        self.steps.append((self.at, {"synchronisation": "dies?"}))
        self._step({"guard": "grip_dead" if session is self.grip else "change_dead"})
        self.rules.declare_dead(session, "killed", self.at * MS)  # type: ignore[arg-type]
        self._look()

    def is_one_of(self, text: str) -> bool:
        """Whether the templates of a UPPAAL file have this run."""
        network = make_network(read_document(self._model(text).encode(), "run.xml"), self._constants())
        return Explorer(network).check("E<> Seen.End").holds

    def _constants(self) -> dict:
        return {**model_constants(self.description), "LEASE": self.policy.lease_us // MS}

    def _renew(self, at: int) -> None:
        for session in (self.grip, self.change):
            if not session.ended:
                self.rules.renew(session, at)

    def _look(self) -> None:
        self._step({"guard": f"refusing == NONE && {self._seen()}"})

    def _step(self, labels: dict[str, str]) -> None:
        self.steps.append((self.at, labels))

    def _seen(self) -> str:
        names = [f"line[{index}]" for index in range(len(self.names))] + ["line_unlock"]
        names += [f"line_blow[{index}]" for index in self.blow_offs.values()]
        levels = [self.lines.levels[name] for name in (*self.names, self.unlock, *self.blow_offs)]
        return " && ".join(name if level else f"!{name}" for name, level in zip(names, levels, strict=True))

    def _model(self, text: str) -> str:
        """The declarations, the two templates, and a process that asks for this run, step by step."""
        head = text[: text.index("\t<template>")]
        kept = "".join(_KEPT.findall(text))
        return f"{head}{kept}{seen(self.steps)}<system>system Seen, Arbiter, Blower, Wills;</system></nta>"


def random_run(
    description: Description, policy: Policy, seed: int, rules: type[LineArbiter] = LineArbiter
) -> Run:
    """Both clients write as they like, one of them dies in the middle of it."""
    chooser, run = random.Random(seed), Run(description, policy, rules)
    run.left = tuple(line for line in run.names if chooser.random() < 0.2)
    mortal = chooser.choice([run.grip, run.grip, run.change])
    for _ in range(chooser.randrange(4, 14)):
        run.to(run.at + chooser.choice([10, 60, 400, 1700]))
        if run.blow_offs and chooser.random() < 0.5:
            run.blows(chooser.choice([*run.blow_offs]), chooser.random() < 0.7)
        elif chooser.random() < (0.6 if mortal is run.change else 0.15):
            run.unlocks(chooser.random() < 0.7)
        else:
            line = chooser.choice(run.names)
            run.grips(chooser.choice(_STATES), line, chooser.random() < 0.75)
    active = [run.unlock] if mortal is run.change else [*run.names, *run.blow_offs]
    run.to(run.at + 30)
    if any(run.lines.levels[line] for line in active):
        run.dies(mortal)
        for _ in range(3):
            run.to(run.at + chooser.choice([200, 1500, 2500]))
            if mortal is run.grip and chooser.random() < 0.5:
                run.unlocks(chooser.random() < 0.5)
    run.to(run.at + 8000)
    run._look()
    return run
