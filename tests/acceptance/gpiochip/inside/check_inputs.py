"""In the guest, on the kernel's simulated chip: inputs with bias, debounce and edges, and a whole tool of them."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import DigitalInput
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs import InputsReader
from end_effector_hal.wires.inputs._gpiod import GpiodInputLines
from end_effector_hal.wires.inputs._lines import LineEdge
from tests.acceptance.gpiochip.inside.simulated import SimulatedChip
from tests.support.patience import wait_until

A, B = "IN_A", "IN_B"
DEBOUNCE_MS = 200
"""Longer than what a loaded guest may need for two writes to a file."""
EDGE_S = 0.03
"""A simulated line interrupts at the next tick of the kernel; what changes twice before that is one edge, or none."""
READY_S = 60.0


@pytest.fixture
def chip() -> Iterator[SimulatedChip]:
    with SimulatedChip([A, "", B]) as chip:
        yield chip


def next_edge(lines: GpiodInputLines) -> LineEdge:
    """Waits for the one edge that comes."""
    edges: list[LineEdge] = []

    def came() -> bool:
        found = lines.edges()
        assert not found.lost
        edges.extend(found.edges)
        return bool(edges)

    wait_until("an edge comes", came)
    (edge,) = edges
    return edge


@contextmanager
def claimed(**inputs: DigitalInput) -> Iterator[GpiodInputLines]:
    lines = GpiodInputLines()
    lines.request(inputs)
    try:
        yield lines
    finally:
        lines.close()


def test_the_bias_of_the_description_is_that_of_the_line(chip: SimulatedChip) -> None:
    up, down = DigitalInput(line=A, bias="pull_up"), DigitalInput(line=B, bias="pull_down")
    with claimed(**{A: up, B: down}) as lines:
        assert lines.levels() == {A: True, B: False}
        assert (chip.level(A), chip.level(B)) == (True, False)
        chip.pull(A, False)  # a switch to ground
        assert lines.levels() == {A: False, B: False}


def test_an_edge_has_the_time_at_which_the_kernel_saw_it(chip: SimulatedChip) -> None:
    with claimed(**{A: DigitalInput(line=A), B: DigitalInput(line=B)}) as lines:
        lines.levels()
        for line, level in ((A, True), (B, True), (A, False), (B, False)):
            begin = now_us()
            chip.pull(line, level)
            edge = next_edge(lines)
            assert (edge.line, edge.high) == (line, level)
            assert begin <= edge.at <= now_us()


def test_a_line_that_is_polled_gives_edges_without_the_kernel(chip: SimulatedChip) -> None:
    line = f"{chip.device.name}:1"
    with claimed(**{A: DigitalInput(line=A), line: DigitalInput(line=line, poll_ms=5)}) as lines:
        assert lines.levels() == {A: False, line: False}
        assert (len(lines.fds()), lines.due() is None) == (1, False)
        for level in (True, False):
            chip.pull("", level)
            edge = next_edge(lines)
            assert (edge.line, edge.high) == (line, level)
            assert edge.at <= now_us()


def test_a_bounce_is_no_edge_and_what_stays_is_one_after_the_debounce(chip: SimulatedChip) -> None:
    with claimed(**{A: DigitalInput(line=A, debounce_ms=DEBOUNCE_MS)}) as lines:
        assert lines.levels() == {A: False}
        for level in (True, False) * 3:
            chip.pull(A, level)
            time.sleep(EDGE_S)
        time.sleep(2 * DEBOUNCE_MS / 1000)
        assert not lines.edges().edges
        assert lines.levels() == {A: False}
        begin = now_us()
        chip.pull(A, True)
        assert lines.levels() == {A: False}, "as the kernel debounces it"
        edge = next_edge(lines)
        assert edge.high
        assert edge.at >= begin + DEBOUNCE_MS * 1000
        assert lines.levels() == {A: True}


def test_edges_that_the_kernel_could_not_keep_are_told(chip: SimulatedChip) -> None:
    with claimed(**{A: DigitalInput(line=A)}) as lines:
        for level in (*(True, False) * 20, True):  # more than it keeps for one line
            chip.pull(A, level)
            time.sleep(EDGE_S)
        assert lines.edges().lost
        assert lines.levels() == {A: True}
        chip.pull(A, False)
        assert not next_edge(lines).high


CHANNELS = f"""
schema: 2
name: inside
lines: {{backend: gpiod}}
inputs: {{period_ms: 50}}
channels:
  part: {{digital: {{line: {A}, bias: pull_up, debounce_ms: 2}}, invert: true}}
sequence: [jaw]
actuators: {{jaw: {{kind: gripper, line: JAW, part_bit: part}}}}
supply: {{channel: none}}
"""


def test_a_chip_that_goes_and_comes_back_is_read_again(chip: SimulatedChip, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(CHANNELS)
    frames: list[Frame] = []
    with InputsReader(load_tool(path), frames.append) as reader:
        wait_until("it is read", lambda: bool(frames) and frames[-1].values == {"part": False})
        chip.pull(A, False)
        wait_until("the switch closes", lambda: frames[-1].values == {"part": True})
        chip.unplug()
        wait_until("the alarm", lambda: bool(reader.health.error))
        with SimulatedChip([A], "again"):
            wait_until("it is read again", lambda: not reader.health.error)
            wait_until("as it stands there", lambda: frames[-1].values == {"part": False})


NAMES = ("JAW", "UNLOCK", "PART", "OPEN", "STOP", "LOCKED", "UNLOCKED", "STAND")
TOOL = """
schema: 2
name: inside
lines: {{backend: gpiod, socket: {socket}}}
inputs: {{period_ms: 20}}
channels:
  part: {{digital: {{line: PART, bias: pull_up, debounce_ms: 2}}, invert: true}}
  opened: {{digital: {{line: OPEN, bias: pull_up, debounce_ms: 2}}, invert: true}}
  stop_closed: {{digital: {{line: STOP}}}}
  locked: {{digital: {{line: LOCKED}}}}
  unlocked: {{digital: {{line: UNLOCKED}}}}
  stand: {{digital: {{line: STAND}}}}
sequence: [jaw]
actuators:
  jaw: {{kind: gripper, line: JAW, part_bit: part, open_bit: opened, timeout_s: 10, release_s: 10, reset_s: 1}}
tool_changer: {{line: UNLOCK, locked_bit: locked, unlocked_bit: unlocked, stand_bit: stand, present_bit: none,
  prove_s: 10, unlock_max_s: 20}}
e_stop: {{channel: stop_closed}}
supply: {{channel: none}}
"""


class Jaw:
    """A jaw and a changer at the far ends of the lines; the switches of the jaw close to ground.

    On this chip the bias of a line that is claimed takes the place of what is wired to it: a switch closes again.
    """

    def __init__(self, chip: SimulatedChip) -> None:
        self._chip, self._ended = chip, threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._shown = {"STOP": True, "STAND": False}
        self._follow()
        self._thread.start()

    def show(self, **levels: bool) -> None:
        self._shown |= levels
        self._follow()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    def _follow(self) -> None:
        closes, unlocks = self._chip.level("JAW"), self._chip.level("UNLOCK")
        levels = {"PART": not closes, "OPEN": closes, "LOCKED": not unlocks, "UNLOCKED": unlocks}
        for name, level in (levels | self._shown).items():
            if self._chip.level(name) is not level:
                self._chip.pull(name, level)

    def _run(self) -> None:
        while not self._ended.wait(0.01):
            self._follow()


@pytest.fixture
def jaw() -> Iterator[Jaw]:
    with SimulatedChip(NAMES) as chip:
        device = Jaw(chip)
        yield device
        device.close()


@pytest.fixture
def tool(jaw: Jaw, tmp_path: Path) -> Iterator[EndEffector]:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL.format(socket=tmp_path / "arbiter"))
    eehal = [sys.executable, "-c", "from end_effector_hal.cli import main; main()"]
    log = (tmp_path / "log").open("w+")
    arbiter = subprocess.Popen([*eehal, "arbiter", str(path)], stdout=log, stderr=subprocess.STDOUT)
    try:
        wait_until("the arbiter is ready", lambda: "ready" in (tmp_path / "log").read_text())
        with EndEffector.open(path) as opened:
            opened.wait_ready(READY_S)
            yield opened
    finally:
        arbiter.terminate()
        arbiter.wait(READY_S)
        log.close()


def test_a_tool_whose_sensors_are_all_lines_of_the_board_grips_and_drops(tool: EndEffector) -> None:
    wait_until("it is locked", lambda: tool.lock().succeeded)
    result = tool.grip()
    assert result.succeeded, result.reason
    assert tool.status.ee == EndEffectorState.GRIPPED
    result = tool.drop()
    assert result.succeeded, result.reason


def test_the_arbiter_reads_the_e_stop_and_refuses(tool: EndEffector, jaw: Jaw) -> None:
    wait_until("it is locked", lambda: tool.lock().succeeded)
    assert tool.grip().succeeded
    jaw.show(STOP=False)
    wait_until("it is latched", lambda: "IL-13: the emergency stop was opened." in tool.status.alarm_texts)
    assert tool.status.ee == EndEffectorState.GRIPPED, "what is held stays held"
    assert not tool.reset().accepted
    jaw.show(STOP=True)
    wait_until("it is reset", lambda: tool.reset().accepted)
    assert tool.drop().succeeded


def test_the_arbiter_reads_the_stand_and_unlocks_only_there(tool: EndEffector, jaw: Jaw) -> None:
    wait_until("it is locked", lambda: tool.lock().succeeded)
    refused = tool.unlock()
    assert not refused.succeeded
    assert "IL-02" in refused.reason
    jaw.show(STAND=True)
    wait_until("it unlocks", lambda: tool.unlock().succeeded)
