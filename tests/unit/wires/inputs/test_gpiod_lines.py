"""Digital inputs through libgpiod: its own types, on a stand-in for the kernel."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from types import SimpleNamespace

import gpiod
import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import DigitalInput
from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires.inputs import _gpiod as inputs_module
from end_effector_hal.wires.inputs import lines_of
from end_effector_hal.wires.inputs._gpiod import GpiodInputLines
from end_effector_hal.wires.inputs._lines import LineEdge
from end_effector_hal.wires.lines import _gpiod as module
from tests.support.input_kernel import InputKernel
from tests.support.places import ROOT

A, B, C = (DigitalInput(line=name) for name in ("GPIO17", "GPIO27", "EXP_3"))
ALL = {each.line: each for each in (A, B, C)}
FUTURE_NS = 10**18


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> InputKernel:
    kernel = InputKernel(tmp_path, gpiochip0=["", "GPIO17", "GPIO27"], gpiochip1=["EXP_3", "TWIN", "TWIN"])
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    return kernel


@pytest.fixture
def lines(kernel: InputKernel) -> Iterator[GpiodInputLines]:
    lines = GpiodInputLines(kernel.pattern)
    yield lines
    lines.close()
    assert not any(chip.held_by for chip in kernel.chips.values())


def test_lines_are_claimed_with_bias_debounce_edges_and_the_monotonic_clock(
    kernel: InputKernel, lines: GpiodInputLines
) -> None:
    lines.request({"GPIO17": DigitalInput(line="GPIO17", bias="pull_up", debounce_ms=5), "GPIO27": B})
    request = kernel.chip_of("GPIO17").request
    assert request is not None
    line = gpiod.line
    assert request.config[1] == gpiod.LineSettings(
        direction=line.Direction.INPUT,
        edge_detection=line.Edge.BOTH,
        bias=line.Bias.PULL_UP,
        debounce_period=timedelta(milliseconds=5),
        event_clock=line.Clock.MONOTONIC,
    )
    assert request.config[2].bias == line.Bias.AS_IS
    assert kernel.chip_of("GPIO17").held_by == {1: "end-effector-hal inputs", 2: "end-effector-hal inputs"}


def test_edges_of_two_chips_come_in_the_order_of_the_kernels_time(
    kernel: InputKernel, lines: GpiodInputLines
) -> None:
    lines.request(ALL)
    kernel.drive("EXP_3", True, 5_000)
    kernel.drive("GPIO17", True, 4_000)
    kernel.drive("GPIO27", True, 6_000)
    kernel.drive("GPIO17", False, 7_000)
    assert lines.edges() == (
        [
            LineEdge(4, "GPIO17", True),
            LineEdge(5, "EXP_3", True),
            LineEdge(6, "GPIO27", True),
            LineEdge(7, "GPIO17", False),
        ],
        False,
    )
    assert lines.edges() == ([], False)
    assert len(lines.fds()) == 2


def test_what_the_kernel_overwrote_is_a_gap_and_told_once(
    kernel: InputKernel, lines: GpiodInputLines
) -> None:
    lines.request({"GPIO17": A})
    for count in range(40):
        kernel.drive("GPIO17", count % 2 == 0, count * 1000)
    edges, lost = lines.edges()
    assert lost
    assert [edge.at for edge in edges] == list(range(24, 40))
    kernel.drive("GPIO17", True, 50_000)
    assert lines.edges() == ([LineEdge(50, "GPIO17", True)], False)


def test_an_edge_before_the_levels_were_read_is_in_them(kernel: InputKernel, lines: GpiodInputLines) -> None:
    lines.request({"GPIO17": A})
    kernel.drive("GPIO17", True, 1_000)
    assert lines.levels() == {"GPIO17": True}
    kernel.drive("GPIO17", False, FUTURE_NS)
    assert lines.edges() == ([LineEdge(FUTURE_NS // 1000, "GPIO17", False)], False)


def test_a_busy_line_is_said_with_who_has_it_and_nothing_stays_claimed(
    kernel: InputKernel, lines: GpiodInputLines
) -> None:
    kernel.chip_of("EXP_3").held_by[0] = "fan-control"
    with pytest.raises(LineBusyError, match="EXP_3 is held by fan-control"):
        lines.request(ALL)
    assert not kernel.chip_of("GPIO17").held_by
    kernel.chip_of("EXP_3").held_by.clear()


@pytest.mark.parametrize(
    ("name", "said"), [("GPIO117", "did you mean GPIO17"), ("TWIN", "TWIN is ambiguous.*line 1 and .*line 2")]
)
def test_a_name_that_is_missing_or_ambiguous(lines: GpiodInputLines, name: str, said: str) -> None:
    with pytest.raises(LineNotFoundError, match=said):
        lines.request({name: A})


def test_a_chip_that_vanishes_is_a_sentence(kernel: InputKernel, lines: GpiodInputLines) -> None:
    lines.request({"GPIO17": A})
    kernel.chip_of("GPIO17").gone = True
    with pytest.raises(WireError, match=r"do not work any more: No such device.*as soon as it is back"):
        lines.levels()
    with pytest.raises(WireError, match="do not work any more"):
        lines.edges()


POLLED = DigitalInput(line="gpiochip1:1", poll_ms=1)


def test_a_chip_without_edges_is_refused_with_the_key_that_helps(
    kernel: InputKernel, lines: GpiodInputLines
) -> None:
    kernel.chip_of("EXP_3").edges = False
    with pytest.raises(WireError, match=r"reports no edges of the input lines EXP_3\. Write poll_ms: 10"):
        lines.request({"GPIO17": A, "EXP_3": C})


def test_a_polled_line_gives_an_edge_when_its_level_was_read(
    kernel: InputKernel, lines: GpiodInputLines, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel.chip_of("EXP_3").edges = False
    now_ns = [5_000_000]
    monkeypatch.setattr(inputs_module.time, "monotonic_ns", lambda: now_ns[0])
    monkeypatch.setattr(inputs_module, "now_us", lambda: now_ns[0] // 1000)
    lines.request({"GPIO17": A, "gpiochip1:1": POLLED})
    assert lines.levels() == {"GPIO17": False, "gpiochip1:1": False}
    assert len(lines.fds()) == 1
    kernel.chip_of("TWIN").high["TWIN"] = True
    now_ns[0] += 999_000
    assert (lines.due(), lines.edges()) == (6_000, ([], False))
    now_ns[0] += 1_000
    assert lines.edges() == ([LineEdge(6_000, "gpiochip1:1", True)], False)
    assert (lines.due(), lines.edges()) == (7_000, ([], False))
    now_ns[0] += 1_000_000
    assert (lines.edges(), lines.due()) == (([], False), 8_000)


def test_an_input_that_is_an_output_of_the_tool_is_not_claimed(kernel: InputKernel) -> None:
    """As an input the line of a valve would be inactive, and drop what is held."""
    lines, one = GpiodInputLines(kernel.pattern, outputs=["absent", "GPIO17"]), "gpiochip0:1"
    with pytest.raises(WireError, match="are one line"):
        lines.request({one: DigitalInput(line=one)})
    assert not kernel.chip_of("GPIO17").held_by


def test_an_input_may_have_the_name_of_an_actuator_on_a_bus(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The output of such an actuator is a register: no line of the board must be kept free of it."""
    tool = load_tool(ROOT / "examples/tools/gripper_2f85/end_effector.yaml")
    (name,) = tool.register_outputs
    kernel, one = InputKernel(tmp_path, gpiochip0=[name]), "gpiochip0:0"
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    lines = lines_of(tool)
    assert isinstance(lines, GpiodInputLines)
    monkeypatch.setattr(lines, "_pattern", kernel.pattern)
    lines.request({one: DigitalInput(line=one)})
    assert lines.levels() == {one: False}
    lines.close()
