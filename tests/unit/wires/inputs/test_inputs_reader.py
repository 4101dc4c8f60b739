"""The reader of a board's inputs: frames at the start, with the period and at edges, whatever fails."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from end_effector_hal.description import Description
from end_effector_hal.description.reading._examine import examine_text
from end_effector_hal.errors import LineBusyError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import Claim, now_us
from end_effector_hal.wires.inputs import InputsHealth, InputsReader
from end_effector_hal.wires.inputs._gpiod import GpiodInputLines
from end_effector_hal.wires.lines import VirtualChip, VirtualPins
from end_effector_hal.wires.lines import _gpiod as module
from end_effector_hal.wires.sensors import SensorReader
from tests.support.input_kernel import InputKernel
from tests.support.patience import wait_until

TOOL = """
schema: 2
name: mixed
lines: {{backend: virtual, path: {folder}/chip}}
inputs: {{period_ms: {period_ms}, iio: {folder}/iio}}
channels:
  switch: {{digital: {{line: A, bias: pull_up}}, invert: true}}
  part: {{digital: {{line: B}}}}
  cup: {{analog: {{device: ads1015, channel: voltage0}}, unit: kPa, scale: 0.05, offset: -100}}
sequence: [one, two]
actuators:
  one: {{kind: vacuum, line: OUT1, channel: switch}}
  two: {{kind: vacuum, line: OUT2, channel: cup}}
supply: {{channel: none}}
"""


def described(folder: Path, period_ms: int = 10) -> Description:
    examination = examine_text(TOOL.format(folder=folder, period_ms=period_ms), folder / "tool.yaml")
    assert examination.description, examination.lines()
    return examination.description


class Board:
    """Its chip and its converter, and what a reader has told."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.chip = VirtualChip.create(folder / "chip", ["A", "B", "OUT1", "OUT2"], {"A": "up"}).path
        self.pins = VirtualPins(self.chip)
        self.adc = folder / "iio" / "iio:device0"
        self.adc.mkdir(parents=True)
        (self.adc / "name").write_text("ads1015\n")
        self.convert("1000")
        self.frames: list[Frame] = []
        self.told: list[InputsHealth] = []

    def convert(self, text: str) -> None:
        (self.adc / "new").write_text(text)
        (self.adc / "new").replace(self.adc / "in_voltage0_raw")

    def reader(self, period_ms: int = 10) -> InputsReader:
        return InputsReader(described(self.folder, period_ms), self.frames.append, self.told.append)

    def comes(self, what: Callable[[Frame], bool]) -> Frame:
        """The next frame from now on of which this is true."""
        known = len(self.frames)
        found = wait_until("such a frame", lambda: [each for each in self.frames[known:] if what(each)])
        return found[0]


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    board = Board(tmp_path)
    yield board
    board.pins.close()


def test_the_first_frame_has_all_channels_and_more_follow_with_the_period(board: Board) -> None:
    with board.reader():
        wait_until("five frames", lambda: len(board.frames) >= 5)
    first = board.frames[0]
    assert dict(first.values) == {"switch": False, "part": False, "cup": -50_000}
    assert (first.seq, first.device_ms) == (None, None)
    stamps = [frame.at for frame in board.frames]
    assert stamps == sorted(stamps)
    assert stamps[4] - stamps[0] >= 4 * 10_000 - 5_000
    assert stamps[-1] <= now_us()


def test_an_edge_is_a_frame_of_its_line_at_once(board: Board) -> None:
    with board.reader(period_ms=1000):
        wait_until("the first frame", lambda: board.frames)
        before = now_us()
        board.pins.drive({"A": False})
        wait_until("the edge", lambda: len(board.frames) > 1)
    assert dict(board.frames[1].values) == {"switch": True}
    assert before <= board.frames[1].at <= now_us()


def test_edges_that_waited_keep_their_order(board: Board) -> None:
    gate = SimpleNamespace(open=False)

    def slow(frame: Frame) -> None:
        board.frames.append(frame)
        wait_until("it goes on", lambda: gate.open)

    with InputsReader(described(board.folder, 1000), slow):
        wait_until("the first frame", lambda: board.frames)
        for level in (True, False, True):
            board.pins.drive({"B": level})
        board.pins.drive({"A": False})
        gate.open = True
        wait_until("the edges", lambda: len(board.frames) >= 5)
    assert [dict(frame.values) for frame in board.frames[1:5]] == [
        {"part": True},
        {"part": False},
        {"part": True},
        {"switch": True},
    ]


def test_an_analog_channel_that_cannot_be_read_is_invalid_and_the_others_go_on(board: Board) -> None:
    with board.reader() as reader:
        board.comes(lambda frame: frame.values.get("cup") == -50_000)
        board.convert("garbage")
        frame = board.comes(lambda frame: "cup" in frame.values and frame.values["cup"] is None)
        assert frame.values["switch"] is False
        wait_until("the alarm", lambda: "cup cannot be read" in reader.health.error)
        board.convert("1100")
        board.comes(lambda frame: frame.values.get("cup") == -45_000)
        wait_until("the alarm", lambda: not reader.health.error)
    assert [bool(health.error) for health in board.told] == [True, False]


def test_a_chip_that_vanishes_comes_back_by_itself(board: Board) -> None:
    with board.reader() as reader:
        board.comes(lambda frame: "switch" in frame.values)
        kept = board.chip.with_name("kept")
        board.chip.rename(kept)
        wait_until("the alarm", lambda: "the virtual chip has gone" in reader.health.error)
        frame = board.comes(lambda frame: True)
        assert set(frame.values) == {"cup"}  # not refreshed: stale by time
        kept.rename(board.chip)
        board.comes(lambda frame: "switch" in frame.values)
        wait_until("the alarm", lambda: not reader.health.error)
        assert reader.health.opened == 2
        board.pins.drive({"B": True})
        board.comes(lambda frame: frame.values.get("part") is True)


def test_a_line_in_use_is_refused_at_the_start_with_who_has_it(board: Board) -> None:
    claim = Claim(f"{board.chip}.inputs.lock", "an input line of the virtual chip")
    with pytest.raises(LineBusyError, match=rf"is held by pid {os.getpid()}"):
        board.reader().start(patience_s=0.0)
    claim.release()
    with board.reader():
        board.comes(lambda frame: "switch" in frame.values)


def test_a_predecessor_that_is_ending_is_waited_for(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    claim = Claim(f"{board.chip}.inputs.lock", "an input line of the virtual chip")
    from end_effector_hal.wires.inputs import _reader

    monkeypatch.setattr(_reader.time, "sleep", lambda seconds: claim.release())
    with board.reader():
        board.comes(lambda frame: "switch" in frame.values)


def test_no_chip_yet_is_no_error_but_told(board: Board) -> None:
    kept = board.chip.with_name("kept")
    board.chip.rename(kept)
    with board.reader() as reader:
        assert "there is no virtual chip" in reader.health.error
        board.comes(lambda frame: set(frame.values) == {"cup"})
        kept.rename(board.chip)
        board.comes(lambda frame: "switch" in frame.values)


def test_a_listener_that_raises_is_no_end(board: Board, caplog: pytest.LogCaptureFixture) -> None:
    def fail(frame: Frame) -> None:
        board.frames.append(frame)
        raise SystemExit("no")

    with InputsReader(described(board.folder), fail):
        wait_until("frames", lambda: len(board.frames) > 3)


def test_nothing_is_delivered_after_the_end(board: Board) -> None:
    reader = board.reader()
    reader.start()
    wait_until("a frame", lambda: board.frames)
    reader.close()
    count = len(board.frames)
    board.pins.drive({"B": True})
    assert len(board.frames) == count
    reader.close()
    with board.reader():  # and the lines are free
        wait_until("a frame", lambda: len(board.frames) > count)


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> InputKernel:
    (tmp_path / "dev").mkdir()
    kernel = InputKernel(tmp_path / "dev", gpiochip0=["A", "B"])
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    return kernel


def on_kernel(board: Board, kernel: InputKernel, period_ms: int) -> InputsReader:
    lines = GpiodInputLines(kernel.pattern)
    return InputsReader(
        described(board.folder, period_ms), board.frames.append, board.told.append, lines=lines
    )


def test_after_a_gap_the_level_is_read_anew(board: Board, kernel: InputKernel) -> None:
    with on_kernel(board, kernel, 1000) as reader:
        wait_until("the first frame", lambda: board.frames)
        request = kernel.chip_of("A").request
        assert request is not None
        request._seqno += 5  # edges that nobody has seen
        kernel.chip_of("A").high["B"] = True  # one of them
        kernel.drive("A", True)
        wait_until("the levels", lambda: len(board.frames) >= 3)
        assert reader.health.lost == 1
    assert [dict(frame.values) for frame in board.frames[1:3]] == [
        {"switch": False},
        {"switch": False, "part": True},
    ]


def test_a_line_that_never_rests_is_read_with_the_period_only_and_said(
    board: Board, kernel: InputKernel
) -> None:
    with on_kernel(board, kernel, 50) as reader:
        wait_until("the first frame", lambda: board.frames)
        deadline = now_us() + 2_000_000
        while "changes more than 20 times in 50 ms" not in reader.health.error and now_us() < deadline:
            for level in (True, False) * 8:
                kernel.drive("B", level)
        assert "The input line B changes more than 20 times in 50 ms" in reader.health.error
        spent_us = board.frames[-1].at - board.frames[0].at
        assert reader.health.frames <= (20 + 2) * (spent_us // 50_000 + 2)
        wait_until("it rests", lambda: not reader.health.error)


def test_a_chip_whose_driver_fails_is_claimed_again(board: Board, kernel: InputKernel) -> None:
    with on_kernel(board, kernel, 10) as reader:
        board.comes(lambda frame: "switch" in frame.values)
        kernel.chip_of("A").gone = True
        wait_until("the alarm", lambda: "do not work any more" in reader.health.error)
        kernel.chip_of("A").gone = False
        board.comes(lambda frame: "switch" in frame.values)
        assert reader.health.opened == 2


def test_the_reader_of_a_tool_without_a_link_reads_its_inputs_alone(board: Board) -> None:
    reader = SensorReader(described(board.folder), board.frames.append)
    reader.start()
    try:
        board.comes(lambda frame: "switch" in frame.values)
        assert not reader.health.links
        assert reader.health.inputs is not None
        assert reader.where == "inputs of the board"
    finally:
        reader.close()
