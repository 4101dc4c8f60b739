"""An output on a bus in virtual time, over a bus and a device that fail, as a question to the model checker: is what
the code did a run of ``bus_output.xml``?"""

from __future__ import annotations

import random

from end_effector_hal.codecs.modbus import RegisterWrite
from end_effector_hal.kinds.stanza import Activation, Handshake, RegisterOutput
from end_effector_hal.kinds.stanza._registers import OppositeRegister
from end_effector_hal.verification.lemmas import BUS_FILE, output_constants
from end_effector_hal.wires.bus import BusOutputs
from tests.support.seen import SeenStep, seen
from timed_automata import make_network, read_document
from timed_automata.explore import Explorer

MS = 1000
OUT = "out"
ON, OFF, ASK, END, RISE, CLEAR = (1, 1), (2, 1), (3, 0), (4, 0), (5, 1), (6, 0)
PLAIN = RegisterOutput(address=0, command_on=ON, command_off=OFF, acknowledge=(CLEAR,))
ACTIVATED = PLAIN.model_copy(
    update={"verify": "told", "activation": Activation(write=(RISE,), ready="ready", ready_within_s=0.5)}
)
APART = ACTIVATED.model_copy(
    update={"activation": Activation(address=9, write=(RISE,), ready="ready", ready_within_s=0.5)}
)
"""No command has an activation bit."""
SHAKEN = PLAIN.model_copy(
    update={"handshake": Handshake(request=ASK, taken="taken", end=END, order="before", within_s=0.3)}
)
AFTER = PLAIN.model_copy(
    update={"handshake": Handshake(request=ASK, taken="taken", end=END, order="after", within_s=0.3)}
)
TWO_COILS = RegisterOutput(
    address=0, command_on=(1,), command_off=(0,), opposite=OppositeRegister(address=9), verify="told"
)
ROWS_OF_A_PAIR = {(0, 1): 1, (9, 1): 2, (9, 0): 7, (0, 0): 8}
"""The rows of the network by address and value."""
CHANNELS = (
    *(f"{name}[{index}]" for name, most in (("ask", 3), ("goes", 9)) for index in range(most)),
    *("withdraw", "reset", "done", "look", "report", "falls", "starts"),
)


class OutputRun:
    """What happens is done to the code, and noted for the network."""

    def __init__(self, output: RegisterOutput, chooser: random.Random) -> None:
        self.output, self.chooser = output, chooser
        self.at, self.steps = 0, list[SeenStep]()
        self.position = self.told = self.taken = self.handed = False
        self.ready = output.activation is None
        self.shake_at: int | None = None
        self.ready_at: int | None = None
        self.staged: bool | None = None
        self.read_first = True
        self.starts()

    def starts(self) -> None:
        self.outputs = BusOutputs({OUT: self.output}, 10_000 * MS)
        self.level: bool | None = None
        self._event("starts")
        self.read_first = True
        self._look()

    def falls(self) -> None:
        self._event("falls")
        self.wait(50)
        self.starts()

    def asks(self) -> None:
        known = self.outputs.known(self.at * MS).get(OUT)
        here = self.level if self.level is not None else known is not False
        self._commands(level=not here)

    def drops(self) -> None:
        self._commands(level=False, drop=True)

    def _commands(self, *, level: bool, drop: bool = False) -> None:
        self.level = level
        self._event(f"ask[{2 if drop else int(level)}]")
        self.outputs.prepare([OUT] if drop else [], {})
        self.outputs.command({OUT: level}, self.at * MS)
        self._look()

    def withdraws(self) -> None:
        mine = self.outputs._outputs[OUT]
        if mine._may_activate and not mine.why:
            self._event("withdraw")
            self.outputs.withdraw([OUT], "an interlock")
            self._look()

    def resets(self) -> None:
        clears = self.output.acknowledge is not None
        if clears and not self.outputs._outputs[OUT].may_hold(self.at * MS):
            self._event("reset")
            self.outputs.acknowledge(self.at * MS)
            self._look()

    def reads(self) -> None:
        """A cycle: what the device shows when it is asked, handed on a moment later."""
        self._device()
        asked_at, shown = self.at, {"told": self.told, "ready": self.ready, "taken": self.taken}
        self.wait(4)
        self._event("report")
        self.read_first = False
        self.outputs.report(shown, self.at * MS, asked_at * MS)
        self._look()

    def writes(self) -> None:
        """What is due, if the bus may write; it is done, lost on its way, or its answer is."""
        write = None if self.read_first else self.outputs.next_write(self.at * MS)
        if write is None:
            return
        pair, row = self.output.opposite is not None, write.values[0]
        self._event(f"goes[{ROWS_OF_A_PAIR[write.address, row] if pair else row}]")
        self.outputs.sent(write)
        outcome = self.chooser.choice(["done"] * 6 + ["lost", "unheard"])
        if outcome != "lost":
            self._reach(write)
        for _ in range(self.chooser.choice([0, 0, 0, 0, 1, 2])):
            self.chooser.choice([self.asks, self.asks, self.drops])()  # while the answer is on its way
        self.wait(10)
        self.read_first = True
        if outcome == "done":
            self._event("done")
            self.outputs.acknowledged(self.at * MS)
        else:
            self.wait(30)
            self.outputs.failed(self.at * MS)
        self._look()

    def wait(self, ms: int) -> None:
        self.at += ms

    def _device(self) -> None:
        if self.ready_at is not None and self.ready_at <= self.at:
            self.ready, self.ready_at = True, None
        if self.shake_at is not None and self.shake_at <= self.at:
            self.shake_at, self.taken = None, not self.taken
            if self.taken and self.staged is not None:
                self._obey(self.staged)
                self.staged = None
            self.handed = self.handed or not self.taken

    def _reach(self, write: RegisterWrite) -> None:
        self._device()
        shake, late = self.output.handshake, self.chooser.choice([2, 2, 2, 400])
        if self.output.opposite is not None:
            if write.values == (1,):
                self._obey(write.address == 0)
        elif write.values in (ON, OFF):
            if shake is None or (shake.order == "before" and self.handed):
                self.handed = False
                self._obey(write.values == ON)
            elif shake.order == "after":
                self.staged = write.values == ON
        elif write.values in (ASK, END):
            asks = write.values == ASK
            self.shake_at = self.at + late if asks != self.taken else None
        elif write.values == RISE:
            self.position = self.told = self.ready = False
            self.ready_at = self.at + late

    def _obey(self, level: bool) -> None:
        if self.ready:
            self.position = self.told = level

    def _event(self, channel: str) -> None:
        self.wait(2)
        self.steps.append((self.at, {"never": self._never("")}))
        self.steps.append((self.at, {"synchronisation": f"{channel}?", "never": self._never(channel)}))

    def _look(self) -> None:
        """What the code makes of it, now."""
        self.outputs.advance(self.at * MS)
        mine = self.outputs._outputs[OUT]
        known = self.outputs.known(self.at * MS).get(OUT)
        marks = [
            f"known() == {'UNKNOWN' if known is None else int(known)}",
            f"{'' if mine.pending else '!'}pending()",
            f"{'' if mine.why else '!'}why",
        ]
        self.steps.append((self.at, {"guard": " && ".join(marks), "never": self._never("")}))

    def _never(self, expected: str) -> str:
        return " ".join(f"{each}?" for each in CHANNELS if each != expected)

    def is_one_of(self, text: str) -> bool:
        """Whether the network of a UPPAAL file has this run."""
        text = text.replace("\t<system>", f"{seen(self.steps)}\n\t<system>").replace(
            "Reads, Device;", "Reads, Device, Seen;"
        )
        text = text.replace("restart(h), ", "")  # no device of these runs restarts, or lets go by itself
        values = output_constants(self.output) | {"RELEASES": 0}
        network = make_network(read_document(text.encode(), "run.xml"), values)
        return Explorer(network).check("E<> Seen.End").holds


def random_output_run(output: RegisterOutput, seed: int) -> OutputRun:
    """Anything happens, in any order."""
    run = OutputRun(output, random.Random(seed))
    for _ in range(run.chooser.randrange(10, 40)):
        happens = run.chooser.choices(
            [
                run.asks,
                run.drops,
                run.withdraws,
                run.resets,
                run.reads,
                run.writes,
                run.falls,
                lambda: run.wait(400),
            ],
            [6, 3, 1, 2, 20, 20, 1, 1],
        )[0]
        happens()
    return run


def model_text() -> str:
    return BUS_FILE.read_text(encoding="utf-8")
