"""The line arbiter with its session record in virtual time, and a program that asks for anything, as a question to the
model checker: is what happened a run of ``deaths.xml``? Either dies at any time, the arbiter also between two lines."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

from end_effector_hal.arbiter import Policy
from end_effector_hal.arbiter.protocol import write_message
from end_effector_hal.verification.lemmas import DEATHS_FILE
from tests.support.seen import SeenStep, seen
from tests.unit.arbiter.simulation.disk import SimulatedDisk
from tests.unit.arbiter.simulation.process import ArbiterProcess
from tests.unit.arbiter.simulation.wire import NearEnd
from timed_automata import Document, make_network, read_document
from timed_automata.explore import Explorer

MS = 1000
LINES = ("first", "second")
POLICY = Policy(LINES)
_SYSTEM = "system Program, Arbiter, First, Second;"
_CHANNELS = ("hello?", "accepted?", "refused?", "falls?", "starts?", "written[0]?", "written[1]?")


class KilledError(BaseException):
    """The arbiter dies here."""


class ApartLines:
    """The output lines: each is written apart."""

    def __init__(self, world: DeathRun) -> None:
        self._world = world

    def request(self, names: object) -> dict[str, bool]:
        return dict(self._world.lines)

    def levels(self) -> dict[str, bool]:
        return dict(self._world.lines)

    def set(self, levels: Mapping[str, bool]) -> None:
        for name, level in levels.items():
            self._world.hazard("line")
            self._world.lines[name] = level
            self._world.written(LINES.index(name), level)

    def close(self) -> None:
        """They stay as they are."""


class DeathRun:
    """What happens is done to the arbiter's code, and noted for the network. Times are µs, as in the code."""

    def __init__(self, seed: int) -> None:
        self.random, self.now, self.boot = random.Random(seed), 1_000_000, "boot"
        self.lines = dict.fromkeys(LINES, False)
        self.judge = SimpleNamespace()
        self.memory, self.mark, self.disk = (
            SimulatedDisk(each, self.hazard) for each in ("memory", "mark", "disk")
        )
        self.arbiter: ArbiterProcess | None = None
        self.ends: list[NearEnd] = []
        self.near: NearEnd | None = None
        self.token, self.left, self.state = 0, set[int](), ""
        self.fell = ""
        self.steps: list[SeenStep] = []
        self._held, self._hazards, self._number, self._wrote = False, -1, 0, False

    # What the processes touch

    @property
    def listener(self) -> ArbiterProcess | None:
        return self.arbiter

    def clock(self) -> int:
        return self.now

    def pid(self) -> int:
        return 0

    def message(self, line: bytes) -> None:
        """The arbiter reads one."""
        self.hazard("message")

    def hazard(self, where: str) -> None:
        self._hazards -= 1
        if self._hazards == 0:
            raise KilledError

    @contextmanager
    def inside(self, process: str) -> Iterator[None]:
        yield

    def written(self, line: int, level: bool) -> None:
        self._wrote = True
        if self._held and not level:
            self.fell = f"line {line} at {self.now}"
        self._see(f"written[{line}]?")

    # The arbiter

    def starts(self) -> None:
        """It may be killed in its start."""
        self.now += 2 * MS
        self._maybe_killed()
        self._see("starts?")
        try:
            self.arbiter = ArbiterProcess(self, POLICY)
        except KilledError:
            self._falls()
        else:
            self._replied()

    def killed(self) -> None:
        """Between two messages."""
        self._falls()

    def to(self, at: int) -> None:
        """Time passes; what is due is done when it is due."""
        while self.arbiter is not None and (due := self.arbiter.rules.deadline) is not None and due <= at:
            self.now = max(self.now, due)
            self._round()
        self.now = at
        if self.arbiter is not None:
            self._round()

    def _round(self) -> None:
        """One step of the arbiter without a message."""
        assert self.arbiter
        living = self._session()
        self._wrote = False
        try:
            self.arbiter.step()
        except KilledError:
            if self._session() != living and not self._wrote:
                self._see("accepted?")
            self._falls()
        else:
            if self._wrote or self._session() != living:
                self._replied()

    # The program

    def connects(self) -> None:
        """Says hello, with the last will that it left before."""
        if self.near is None:
            self.token, self.left, self.state = self.token + 1, set(), ""
        self.near = NearEnd(self)
        self.near.connect("")
        reply = self._send("hello", client="grip", token=f"{self.token:032x}", lines=LINES, will=self._will())
        if reply is None:
            return
        if not reply["ok"]:
            self._lose()
            return
        if not any(self.lines.values()):
            self._held = False
            self.state = "free"
        elif self.state != "free" or self.random.random() < 0.5:
            self.state = "found"

    def asks(self) -> None:
        """Anything, but for what it holds."""
        if self.state == "held" and self.random.random() < 0.3:
            self.state, self._held = "free", False
        if self.state == "found":
            levels, self.left = dict(self.lines), set()
        elif self.state == "held":
            levels = {}
        else:
            levels = {line: self.random.random() < 0.5 for line in LINES if self.random.random() < 0.6}
            active = {at for at, line in enumerate(LINES) if levels.get(line, self._will_be(line))}
            self.left = {at for at in active if self.random.random() < 0.6}
        before = self.left
        reply = self._send("set", levels=levels, will=self._will())
        if reply is not None and reply["ok"]:
            if self.state == "found":
                self.state, self._held = "held", True
        elif reply is not None:
            self.left = before

    def leaves(self) -> None:
        """In order, with any last will of what it does not hold."""
        active = {at for at, line in enumerate(LINES) if self._will_be(line)}
        self.left = {at for at in active if self.state == "free" and self.random.random() < 0.5}
        self._send("bye", will=self._will())
        self.near = None

    def dies(self) -> None:
        """Its connection is closed by the kernel."""
        near, self.near = self.near, None
        self._loses(near)

    def breaks(self) -> None:
        """The connection is lost, the program lives."""
        self._loses(self.near)

    def _loses(self, near: NearEnd | None) -> None:
        if near is None or not near.is_open:
            return
        living, self._wrote = self._session(), False
        try:
            near.close()
            if self.arbiter is not None:
                self.arbiter.step()
        except KilledError:
            self._falls()
        else:
            if self.arbiter is not None and (self._wrote or self._session() != living):
                self._replied()

    def _lose(self) -> None:
        """The arbiter has refused the hello; the program closes."""
        if self.near is not None:
            self.near.close()

    # What is noted

    def _send(self, op: str, **fields: Any) -> dict[str, Any] | None:
        """The reply; None: the arbiter died, or had ended the connection."""
        assert self.near
        if self.near.is_lost or self.arbiter is None:
            return None
        self._number += 1
        self._see(self._seen_as(op, fields))
        self._wrote = False
        try:
            self.near.sendall(write_message({"id": self._number, "op": op, **fields}))
            reply: dict[str, Any] = json.loads(self.near.recv(0).splitlines()[-1])
            if not reply["ok"]:
                self._see("refused?")
            self.arbiter.step()
        except KilledError:
            self._falls()
            return None
        self._replied()
        return reply

    def _seen_as(self, op: str, fields: Mapping[str, Any]) -> str:
        will = sum(1 + at for at in self.left)
        if op == "hello":
            return "hello?"
        if op == "bye":
            return f"bye[{will}]?"
        first, second = (1 + fields["levels"][line] if line in fields["levels"] else 0 for line in LINES)
        return f"ask[{12 * first + 4 * second + will}]?"

    def _will(self) -> list[dict[str, object]]:
        later = self.random.choice((0, 300 * MS))
        return [{"line": LINES[at], "level": False, "after_us": later * at} for at in sorted(self.left)]

    def _will_be(self, line: str) -> bool:
        assert self.arbiter
        living = [each for each in self.arbiter.rules.sessions if not each.ended]
        return living[0].queued_level(line, now=self.lines[line]) if living else self.lines[line]

    def _session(self) -> str:
        if self.arbiter is None:
            return "NONE"
        living = [each for each in self.arbiter.rules.sessions if not each.ended]
        return "NONE" if not living else "ABSENT" if living[0].absent else "LIVE"

    def _maybe_killed(self) -> None:
        self._hazards = self.random.randrange(1, 12) if self.random.random() < 0.25 else -1

    def _falls(self) -> None:
        self._hazards = -1
        self.arbiter = None
        for end in self.ends:
            end.is_lost = True
        self._see("falls?")

    def _replied(self) -> None:
        """The arbiter waits for the next message: what can be seen of it must be so."""
        self._see("accepted?")
        assert self.arbiter
        kept = "WHOLE" if self.memory.content else "LOST"
        ended = any(each.ended for each in self.arbiter.rules.sessions)
        marks = [f"{'' if self.lines[line] else '!'}line[{at}]" for at, line in enumerate(LINES)]
        marks += [f"session == {self._session()}", f"record == {kept}", "" if ended else "todo == 0"]
        self._note({"guard": " && ".join(filter(None, marks))}, "")

    def _see(self, channel: str) -> None:
        self._note({}, channel)
        self._note({"synchronisation": channel}, channel)

    def _note(self, labels: dict[str, str], expected: str) -> None:
        never = " ".join(each for each in _CHANNELS if each != expected)
        self.steps.append((self.now // MS, {**labels, "never": never}))

    def is_one_of(
        self, text: str, edit: Callable[[Document], Document] = lambda document: document, **constants: int
    ) -> bool:
        """Whether the network of a UPPAAL file, once it is edited, has this run."""
        text = text.replace("\t<system>", f"{seen(self.steps)}\n\t<system>")
        text = text.replace(_SYSTEM, _SYSTEM.replace(";", ", Seen;"))
        network = make_network(edit(read_document(text.encode(), "run.xml")), constants)
        return Explorer(network).check("E<> Seen.End").holds


def random_death_run(seed: int) -> DeathRun:
    """Anything happens, in any order."""
    run = DeathRun(seed)
    chooser = run.random
    for _ in range(chooser.randrange(8, 30)):
        run._maybe_killed()
        run.to(run.now + chooser.choice([2, 10, 30, 60, 400]) * MS)
        if run.arbiter is None:
            run.starts()
            continue
        for disk in (run.memory, run.mark):
            disk.failing = chooser.random() < 0.04
        if run.near is None or run.near.is_lost or not run.near.is_open:
            if chooser.random() < 0.2:
                run.near = None  # another program
            run.connects()
            continue
        happens = chooser.random()
        if happens < 0.62:
            run.asks()
        elif happens < 0.72:
            run.dies()
        elif happens < 0.78:
            run.breaks()
        elif happens < 0.84:
            run.leaves()
        else:
            run.killed()
    return run


def model_text() -> str:
    return DEATHS_FILE.read_text(encoding="utf-8")
