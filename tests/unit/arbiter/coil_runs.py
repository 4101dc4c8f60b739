"""An output of two coils in virtual time, with deaths of its program and of the arbiter, as a question to the model
checker: is what stood on the wires a run of ``two_coils.xml``?"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._records import recall
from end_effector_hal.arbiter.rules import Session
from end_effector_hal.arbiter.rules._session import ArbiterState, read_arbiter_state
from end_effector_hal.verification.lemmas import COILS_FILE
from end_effector_hal.vocabulary import LastWillStep
from tests.support.seen import SeenStep, seen
from timed_automata import make_network, read_document
from timed_automata.explore import Explorer

MS = 1000
JAW, BACK = "jaw", "back"
Recall = Callable[[ArbiterState | None, JournalEntry], ArbiterState]


class Killed(Exception):
    """The arbiter, between two of its steps."""


class Wires:
    """Both coils. ``killed_at``: the call of `set` that the arbiter does not live to make, from now."""

    def __init__(self) -> None:
        self.levels_now = {JAW: False, BACK: False}
        self.killed_at: int | None = None

    def request(self, names: object) -> dict[str, bool]:
        return dict(self.levels_now)

    def levels(self) -> dict[str, bool]:
        return dict(self.levels_now)

    def set(self, levels: dict[str, bool]) -> None:
        if self.killed_at is not None:
            if self.killed_at == 0:
                raise Killed
            self.killed_at -= 1
        self.levels_now |= levels
        assert not all(self.levels_now.values())

    def close(self) -> None:
        pass


class CoilRun:
    """What happens is done to the arbiter's code, and noted for the network."""

    def __init__(self, policy: Policy, chooser: random.Random, believes: Recall = recall) -> None:
        self.policy, self.chooser, self.believes = policy, chooser, believes
        self.wires, self.at, self.steps = Wires(), 0, list[SeenStep]()
        self.rules: LineArbiter | None = None
        self.session: Session | None = None
        self.program, self.names, self.will = False, 0, ()
        self.record: ArbiterState | None = None
        self.outdated = self.dark = False
        self.disk = JournalEntry({}, clean=False)
        self.boot = 0

    # The arbiter

    def starts(self) -> None:
        """Another arbiter, as `Records` and `JournalThread` would have it start."""
        self._note({"guard": f"kept {'==' if self.record is None else '!='} ABSENT"})
        self._note({"synchronisation": "starts?"})
        entry = self.disk
        self.disk = entry._replace(clean=False)
        before = self.record
        if before is not None and self.outdated:
            before = replace(before, clean=False, doubt="it died while it changed a line")
        self.rules = LineArbiter(
            self.wires, self.policy, self.at * MS, self.believes(before, entry), self._mark
        )
        self._keep()
        if self.program:
            self._hello()
        self._look()

    def killed(self) -> None:
        """Between two messages."""
        self._falls("kept != OUTDATED && !clean")

    def killed_while_it_writes(self, level: bool, before_call: int) -> None:
        """Before it writes the first coil, the second one, or the record."""
        assert self.rules
        assert self.session
        changes = self.rules.levels[JAW] != level and self.rules.deadline is not None
        self.wires.killed_at = before_call
        try:
            self.asks(level, self.chooser.random() < 0.5, looks=False)
        except Killed:
            self._falls("kept == OUTDATED && !clean")
        else:
            if changes and self.outdated:  # before the record
                self._falls("kept == OUTDATED && !clean")
            else:
                self._look()
        finally:
            self.wires.killed_at = None

    def ends(self, *, hurried: bool) -> None:
        """In order, or as it is told twice."""
        assert self.rules
        if self.rules.pulses and not hurried:
            self.to(self.at + 400)
        self.rules.end_pulses()
        self.record = read_arbiter_state(replace(self.rules.state, clean=True).as_json())
        self.disk = JournalEntry({}, True, str(self.boot), pulsed=self.rules.state.pulsed)
        self._falls("clean")

    def power_goes(self) -> None:
        self.wires.levels_now = {JAW: False, BACK: False}
        self.record, self.outdated, self.boot = None, False, self.boot + 1
        self.program = False
        if self.chooser.random() < 0.2:
            self.disk = JournalEntry({}, clean=False)

    # The program

    def connects(self) -> None:
        self.names += 1
        self.will = ()
        try:
            self._hello()
        except LastWillRunsError:
            return
        self.program = True

    def asks(self, level: bool, drops: bool, *, looks: bool = True) -> None:
        assert self.rules
        assert self.session
        self.will = (LastWillStep(JAW),) if drops else ()
        self._note({})
        self._note({"synchronisation": f"wants[{int(level)}]?"}, expected="wants")
        if looks:
            self._note({"guard": f"said == {str(drops).lower()}"})
        self.rules.write(self.session, {JAW: level}, self.will, self.at * MS)
        if looks:
            self._keep()
            self._look()

    def dies(self) -> None:
        """Its connection is closed."""
        assert self.rules
        assert self.session
        self._note({})
        self._note({"synchronisation": "dies?"}, expected="dies")
        self.rules.declare_dead(self.session, "killed", self.at * MS)
        self.program = False
        self._keep()
        self._look()

    def to(self, at: int) -> None:
        """Time passes, in ms; each change is seen just before and just after it."""
        if self.rules is None:
            self.at = at
            return
        while (due := self.rules.deadline) is not None and due <= at * MS:
            if self.program and self.session:
                self.rules.renew(self.session, due)
            before = self._seen()
            self.rules.expire(due)
            self.rules.advance(due)
            self._keep()
            if self._seen() != before:
                self.at = -(-due // MS)
                self.steps.append((self.at - 1, {"guard": before, "never": self._never("")}))
                self._look()
        self.at = at
        if self.program and self.session:
            self.rules.renew(self.session, at * MS)
        self._look()

    def is_one_of(self, text: str, **constants: int) -> bool:
        """Whether the network of a UPPAAL file has this run."""
        text = text.replace("\t<system>", f"{seen(self.steps)}\n\t<system>")
        text = text.replace("Device, Watch;", "Seen;")  # what the coils move is not seen
        pulse_us = self.policy.opposites[JAW].pulse_us
        values = {
            "PULSE": pulse_us // MS,
            "PAUSE": self.policy.opposites[JAW].pause_us // MS,
            "SWITCH": self.policy.min_switch_us // MS,
            "LEASE": self.policy.lease_us // MS,
            "D": 0,
        }
        network = make_network(read_document(text.encode(), "run.xml"), values | constants)
        return Explorer(network).check("E<> Seen.End").holds

    def _hello(self) -> None:
        assert self.rules
        token = f"{self.names:032x}"
        self.session = self.rules.hello("grip", token, (JAW,), self.will, self.at * MS)

    def _falls(self, how: str) -> None:
        self._note({})
        self._note({"synchronisation": "falls?"}, expected="falls")
        self._note({"guard": how})
        self.rules = None

    def _mark(self) -> None:
        self.outdated = True

    def _keep(self) -> None:
        assert self.rules
        self.record, self.outdated = read_arbiter_state(self.rules.state.as_json()), False
        if self.chooser.random() < 0.6:
            self.disk = JournalEntry({}, False, str(self.boot), pulsed=self.rules.state.pulsed)

    def _look(self) -> None:
        self._note({"guard": self._seen()})

    def _seen(self) -> str:
        assert self.rules
        assert self.rules._lines.coils
        guessed = JAW in self.rules._lines.coils.guessed
        if not guessed:
            assert self.rules.read_levels() == self.rules.levels
        marks = {
            "coil[1]": self.wires.levels_now[JAW],
            "coil[0]": self.wires.levels_now[BACK],
            "level == 1": self.rules.levels[JAW],
            "guessed": guessed,
            "alive": True,
        }
        return " && ".join(name if holds else f"!({name})" for name, holds in marks.items())

    def _note(self, labels: dict[str, str], expected: str = "") -> None:
        self.steps.append(
            (self.at, {**labels, "never": self._never(expected or labels.get("synchronisation", ""))})
        )

    def _never(self, expected: str) -> str:
        channels = ("wants[0]?", "wants[1]?", "falls?", "starts?", *(("dies?",) if self.program else ()))
        return " ".join(
            each for each in channels if not expected or not each.startswith(expected.rstrip("?"))
        )


def random_coil_run(policy: Policy, seed: int, believes: Recall = recall) -> CoilRun:
    """Anything happens, in any order."""
    chooser = random.Random(seed)
    run = CoilRun(policy, chooser, believes)
    for _ in range(chooser.randrange(8, 24)):
        run.to(run.at + chooser.choice([2, 10, 60, 110, 400, 1700]))
        if run.rules is None:
            if chooser.random() < 0.25:
                run.power_goes()
            run.starts()
        elif not run.program:
            run.connects()
        else:
            happens, level = chooser.random(), chooser.random() < 0.5
            if happens < 0.5:
                run.asks(level, chooser.random() < 0.5)
            elif happens < 0.58:
                run.dies()
            elif happens < 0.8:
                run.killed()
            elif happens < 0.91:
                run.killed_while_it_writes(level, chooser.randrange(3))
            else:
                run.ends(hurried=chooser.random() < 0.5)
    if run.rules is None:
        run.to(run.at + 50)
        run.starts()
    run.to(run.at + 2500)
    return run


def model_text() -> str:
    return COILS_FILE.read_text(encoding="utf-8")
