"""What the line arbiter does in virtual time, as a question to the model checker: is it a run of its template?"""

from __future__ import annotations

import random
import re
from dataclasses import dataclass, field

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.control import Status, model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.runtime.outputs import Maintenance, OutputMapping
from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.seen import SeenStep, seen
from timed_automata import make_network, read_document
from timed_automata.explore import Explorer

MS = 1000
_KEPT = re.compile(
    r"\t<template>\s*<name[^>]*>(?:Arbiter|UnlockLine|Blower|Wills)</name>.*?</template>\n", re.DOTALL
)
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
    """The rules with their client, and the steps of a process that has seen the same."""

    description: Description
    policy: Policy
    arbiter_type: type[LineArbiter] = LineArbiter
    left: tuple[str, ...] = ()
    """Lines that an unwinding leaves active."""
    steps: list[SeenStep] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.lines, self.at = Lines(), 0
        self.rules = self.arbiter_type(self.lines, self.policy, 0)
        self.names = [actuator.line for _, actuator in self.description.ordered]
        assert self.description.tool_changer
        self.unlock = self.description.tool_changer.line
        self.blow_offs = {
            each.line: self.description.sequence.index(name)
            for name, each in self.description.blow_offs.items()
        }
        self.blowing: set[str] = set()
        self.state = _STATES[0]
        self.hal = self.rules.hello("hal", "a" * 32, [*self.names, self.unlock, *self.blow_offs], (), 0)
        self.mapping = OutputMapping(self.description, Maintenance(self.description))
        self.valve, self.unlocking = dict.fromkeys(self.names, False), False
        self.steps.append((0, {"assignment": "world = LOOSE_TOOL, changer = LOCKED, ee = STAND_BY"}))

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
        """The program writes one line, with the will that control computes for its state."""
        self.valve[line], self.state = level, state
        ee, command = state
        status = self._status(state)
        index = self.names.index(line)
        try:
            self.rules.write(self.hal, {line: level}, self.mapping.last_will(status), self.at * MS)
        except LineRefusedError:
            self.valve[line] = False
        told = f"ee = {int(ee)}, command = {int(command)}, valve[{index}] = {str(self.valve[line]).lower()}"
        told += "".join(f", kept[{at}] = {str(at in status.kept).lower()}" for at in range(len(self.names)))
        channel = "activate" if level else "deactivate"
        self._step({"synchronisation": f"{channel}[{index}]!", "assignment": told})
        self._look()

    def blows(self, line: str, level: bool) -> None:
        """The program begins to blow something off, or ends it."""
        self.blowing = self.blowing | {line} if level else self.blowing - {line}
        will = self.mapping.last_will(self._status(self.state))
        try:
            self.rules.write(self.hal, {line: level}, will, self.at * MS)
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
            self.at,
            ee,
            command,
            idle,
            outputs,
            (),
            held=held,
            kept=kept,
            blowing=blowing,
            unlock_output=self.unlocking,
        )

    def unlocks(self, level: bool) -> None:
        """The program writes the line of the tool changer."""
        self.unlocking = level
        will = self.mapping.last_will(self._status(self.state))
        try:
            self.rules.write(self.hal, {self.unlock: level}, will, self.at * MS)
        except LineRefusedError:
            level = self.unlocking = False
        told = f"unlock_valve = {str(level).lower()}"
        self._step({"synchronisation": "open!" if level else "close!", "assignment": told})
        self._look()

    def dies(self) -> None:
        """The program dies, and the arbiter sees it at once."""
        self._step({})
        self.steps.append((self.at, {"synchronisation": "dies?"}))
        self._step({"guard": "dead"})
        self.rules.declare_dead(self.hal, "killed", self.at * MS)
        self._look()

    def is_one_of(self, text: str) -> bool:
        """Whether the templates of a UPPAAL file have this run."""
        network = make_network(read_document(self._model(text).encode(), "run.xml"), self._constants())
        return Explorer(network).check("E<> Seen.End").holds

    def _constants(self) -> dict:
        return {**model_constants(self.description), "LEASE": self.policy.lease_us // MS}

    def _renew(self, at: int) -> None:
        if not self.hal.ended:
            self.rules.renew(self.hal, at)

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
        """The declarations, the templates, and a process that asks for this run, step by step."""
        head = text[: text.index("\t<template>")]
        kept = "".join(_KEPT.findall(text))
        return f"{head}{kept}{seen(self.steps)}<system>system Seen, Arbiter, UnlockLine, Blower, Wills;</system></nta>"


def random_run(
    description: Description, policy: Policy, seed: int, rules: type[LineArbiter] = LineArbiter
) -> Run:
    """The program writes as it likes, and dies in the middle of it."""
    chooser, run = random.Random(seed), Run(description, policy, rules)
    run.left = tuple(line for line in run.names if chooser.random() < 0.2)
    unlocks = chooser.random() < 0.33
    for _ in range(chooser.randrange(4, 14)):
        run.to(run.at + chooser.choice([10, 60, 400, 1700]))
        if run.blow_offs and chooser.random() < 0.5:
            run.blows(chooser.choice([*run.blow_offs]), chooser.random() < 0.7)
        elif chooser.random() < (0.6 if unlocks else 0.15):
            run.unlocks(chooser.random() < 0.7)
        else:
            line = chooser.choice(run.names)
            run.grips(chooser.choice(_STATES), line, chooser.random() < 0.75)
    run.to(run.at + 30)
    if any(run.lines.levels[line] for line in (run.unlock, *run.names, *run.blow_offs)):
        run.dies()
        for _ in range(3):
            run.to(run.at + chooser.choice([200, 1500, 2500]))
    run.to(run.at + 8000)
    run._look()
    return run
