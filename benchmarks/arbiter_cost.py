"""The cost of the line arbiter: a command through it and directly on the back-end, and the arbiter's resources."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from time import sleep
from typing import Any

from figures import Figures, figures
from usage import Meter, Usage

from end_effector_hal.arbiter import HAL, ArbiterClient, PredicateSender, client_lines
from end_effector_hal.description import load, profile_path
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import VirtualChip, VirtualLines

# The arbiter of the tool without IL-10, whose wait would be all that is measured.
ARBITER = """
import sys
from dataclasses import replace
from end_effector_hal.description import load, profile_path
from end_effector_hal.arbiter import ArbiterServer, arbiter_policy
from end_effector_hal.wires.lines import VirtualLines
chip, socket = sys.argv[1:]
policy = replace(arbiter_policy(load(profile_path())), min_switch_us=0)
with ArbiterServer(VirtualLines(chip), socket, policy, socket + ".journal") as arbiter:
    arbiter.serve(lambda _: print("ready", flush=True))
"""
PROVEN = {"locked": True, "nothing_gripped": True, "parked": True}
TELL_S = 0.04
BLOCK = 100


@dataclass(frozen=True)
class ArbiterCost:
    """Times from a call until the line is written and the call returns; the arbiter's usage while it holds."""

    direct_line: Figures
    direct_return: Figures
    arbiter_line: Figures
    arbiter_return: Figures
    usage: Usage

    @property
    def added_us(self) -> float:
        """Median time that the arbiter adds until the line is written."""
        return self.arbiter_line.median - self.direct_line.median

    def as_json(self) -> dict[str, Any]:
        return asdict(self) | {"added_us": self.added_us}


def measure_arbiter(blocks: int, hold_s: float, say: Callable[[str], None]) -> ArbiterCost:
    """Measure commands in alternating blocks, directly and through the arbiter; then hold for ``hold_s``."""
    description = load(profile_path())
    gripping = [actuator.line for _, actuator in description.ordered]
    line = gripping[0]
    unwind = [LastWillStep(each) for each in reversed(gripping)]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="eehal-arbiter-")))
        lines = description.output_lines
        chips = {name: VirtualChip.create(folder / name, lines).path for name in ("owned", "direct")}
        arbiter = stack.enter_context(_arbiter(chips["owned"], folder / "sock"))
        stack.enter_context(_told(folder / "sock"))
        hal = stack.enter_context(ArbiterClient(folder / "sock", HAL, client_lines(description, HAL)))
        backend = VirtualLines(chips["direct"])
        backend.request(lines)
        stack.callback(backend.close)
        # with the will of each step, as the program leaves it
        owned = _Commands(chips["owned"], lambda level: hal.set({line: level}, unwind if level else []))
        direct = _Commands(chips["direct"], lambda level: backend.set({line: level}))
        for block in range(blocks):
            say(f"block {block + 1} of {blocks}")
            direct.run()
            owned.run()
        say(f"holding for {hold_s:g} s")
        hal.set({line: True}, [])
        meter = Meter({"line arbiter": arbiter.pid})
        sleep(hold_s)
        usage = meter.read()["line arbiter"]
    return ArbiterCost(*(direct.found()), *(owned.found()), usage)


class _Commands:
    """Activates and deactivates a line, and reads from its chip when it was written."""

    def __init__(self, chip: Path, write: Callable[[bool], object]) -> None:
        self._records = chip.open("rb")
        self._write = write
        self._to_line: list[int] = []
        self._to_return: list[int] = []

    def run(self) -> None:
        self._records.read()
        for index in range(BLOCK):
            called = now_us()
            self._write(index % 2 == 0)
            returned = now_us()
            (record,) = self._records.read().splitlines()
            self._to_line.append(json.loads(record)["t"] - called)
            self._to_return.append(returned - called)

    def found(self) -> tuple[Figures, Figures]:
        self._records.close()
        to_line, to_return = figures(self._to_line), figures(self._to_return)
        assert to_line
        assert to_return
        return to_line, to_return


@contextmanager
def _arbiter(chip: Path, sock: Path) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-c", ARBITER, str(chip), str(sock)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout
            assert process.stdout.readline() == b"ready\n"
            yield process
        finally:
            process.kill()


@contextmanager
def _told(sock: Path) -> Iterator[None]:
    """Send the sensors' predicates as often as a 50 Hz link does."""
    teller, ended = PredicateSender(sock), threading.Event()

    def tell() -> None:
        while not ended.wait(TELL_S):
            teller.send(PROVEN, now_us())

    thread = threading.Thread(target=tell)
    thread.start()
    while True:
        with ArbiterClient(sock, "look") as look:
            if look.status()["told"]:
                break
    yield
    ended.set()
    thread.join()
    teller.close()
