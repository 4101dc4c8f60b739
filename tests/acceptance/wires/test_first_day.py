"""What a beginner meets on the first day: a device at the far end of a pty, and `eehal` as a person starts it."""

from __future__ import annotations

import json
import re
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.codecs import get_codec, load_tool
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import VirtualChip
from end_effector_hal.wires.link import PtyPair
from end_effector_lab.processes import EEHAL
from tests.support.rtu_server import RtuServer

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
TOOL = """\
schema: 2
name: cup
lines: {{backend: virtual, path: {folder}/chip, socket: {folder}/s}}
link: {{port: {folder}/uart, baudrate: 9600, {link}}}
channels: {{{channels}}}
sequence: [cup]
actuators: {{cup: {{kind: vacuum, line: A, channel: cup}}}}
supply: {{channel: none}}
"""
CUP = "cup: {text: {field: 1}, unit: kPa}"
Far = Callable[[PtyPair, int], None]


class Bench:
    """A tool in a folder, the far end of its link, and `eehal` commands."""

    def __init__(self, folder: Path, far: Far, period_s: float) -> None:
        self.path, self._far, self._period_s = folder / "tool.yaml", far, period_s
        self._pty, self._end = PtyPair(folder / "uart"), threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        number = 0
        while not self._end.wait(self._period_s):
            number += 1
            self._far(self._pty, number)

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self._pty.close()

    def run(self, *words: str) -> tuple[int, str]:
        """Exit code and output of a command that ends by itself."""
        found = subprocess.run(
            [*EEHAL, *words[:1], str(self.path), *words[1:]], capture_output=True, text=True
        )
        return found.returncode, found.stdout + found.stderr

    def alarms(self, script: str) -> list[str]:
        """What `eehal run` alarms of while it plays a script, in its order."""
        arbiter = subprocess.Popen([*EEHAL, "arbiter", str(self.path)], stdout=subprocess.PIPE, text=True)
        try:
            assert arbiter.stdout is not None
            assert arbiter.stdout.readline()
            _, out = self.run("run", "--json", "--script", script)
        finally:
            arbiter.terminate()
            arbiter.communicate()
        told = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
        return [each["text"] for each in told if each["event"] == "alarm"]


@contextmanager
def bench(folder: Path, link: str, channels: str, far: Far, period_s: float) -> Iterator[Bench]:
    text = TOOL.format(folder=folder, link=link, channels=channels)
    (folder / "tool.yaml").write_text(text, "utf-8")
    VirtualChip.create(folder / "chip", load_tool(folder / "tool.yaml").output_lines)
    running = Bench(folder, far, period_s)
    try:
        yield running
    finally:
        running.close()


class Registers:
    """A device with input registers 16 and 17."""

    def __init__(self, *words: int) -> None:
        self._words = list(words)

    def read(self, function: int, address: int, count: int, at: int) -> list[int] | None:
        return self._words[:count] if (function, address) == (4, 16) else None

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        return False


REGISTER = "cup: {{modbus: {{unit: {}, address: {}, register_type: input, value_type: float32}}, unit: kPa}}"
SECOND = ", other: {modbus: {unit: 1, address: 16, register_type: input, value_type: float32}, unit: kPa}"
FAULTS = [
    ((7, 16), "Unit 7, input registers 16 to 17 (cup): no answer. Check its power"),
    ((2, 40), "Unit 2, input registers 40 to 41 (cup): refused with exception 2, illegal data address. Does"),
    (
        (2, 16),
        "Unit 2, input registers 16 to 17 (cup): no sensor can send this value of cup (0x800 0x0). Check",
    ),
]


@pytest.mark.parametrize(
    ("place", "said", "others"), [*((*each, SECOND) for each in FAULTS), (*FAULTS[0], "")]
)
def test_a_modbus_fault_names_unit_register_and_exception(
    place: tuple[int, int], said: str, others: str, tmp_path: Path
) -> None:
    server = RtuServer({1: Registers(0xC27A, 0x147B), 2: Registers(0x0800, 0)})

    def far(pty: PtyPair, _: int) -> None:
        pty.write(server.answer(pty.read(), now_us()))

    with bench(tmp_path, "frame: {modbus: {}}", REGISTER.format(*place) + others, far, 0.001) as tool:
        _, doctor = tool.run("doctor", "--only", "link")
        _, heard = tool.run("listen", "--seconds", "2")
        alarms = tool.alarms("wait 3")
    flat = " ".join(doctor.split())
    assert said in flat, doctor
    assert "cable, its ground" not in flat
    assert said in heard
    assert any(said in alarm for alarm in alarms), alarms
    assert not any("say that the value is invalid" in alarm for alarm in alarms), alarms


def test_a_slow_sketch_is_read_and_its_period_is_named(tmp_path: Path) -> None:
    """`-62.52` every 105 ms, with `frame: {text: {}}`, never was a frame."""
    begun = now_us()

    def far(pty: PtyPair, number: int) -> None:
        pty.write(f"-62.{(now_us() - begun) // 10_000 % 90 + 10}\r\n".encode())

    with bench(tmp_path, "frame: {text: {}}", CUP, far, 0.105) as tool:
        _, doctor = tool.run("doctor", "--only", "link")
        code, heard = tool.run("listen", "--seconds", "5")
        alarms = tool.alarms("wait 4")
    said = re.compile(r"A frame comes every 1\d\d ms, not every 20 ms\. .* set period_ms: 1\d\d\.")
    assert said.search(" ".join(doctor.split())), doctor
    assert (code, "cup is CONFIRMED" in heard) == (0, True), heard
    assert said.search(heard), heard
    assert any(map(said.match, alarms)), alarms


def test_two_senders_on_one_link_are_one_alarm(tmp_path: Path) -> None:
    codec = get_codec("ees1-ascii")

    def far(pty: PtyPair, number: int) -> None:
        first, clock = (100, 5_000) if number % 2 else (9_000, 700_000)
        values = {"bottom": -number, "top": 0, "cylinder": 0, "supply": 600_000}
        pty.write(codec.encode(Frame(0, first + number, clock + 20 * number, values)))

    with bench(tmp_path, "codec: ees1-ascii", "cup: {codec: {channel: bottom}}", far, 0.01) as tool:
        alarms = tool.alarms("wait 4")
    assert sum(alarm.startswith("Two senders on one link") for alarm in alarms) == 1, alarms
    assert len(alarms) < 20, alarms  # there were 100 in a second
