"""Digital inputs of a virtual chip, which somebody else drives."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import DigitalInput
from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs._lines import LineEdge
from end_effector_hal.wires.inputs._virtual import VirtualInputLines
from end_effector_hal.wires.lines import VirtualChip, VirtualLines, VirtualPins
from tests.support.patience import wait_until

A, B = DigitalInput(line="A"), DigitalInput(line="B", bias="pull_up")
BOTH = {"A": A, "B": B}


@pytest.fixture
def chip(tmp_path: Path) -> Path:
    return VirtualChip.create(tmp_path / "chip", ["A", "B", "OUT"], {"B": "up"}).path


@pytest.fixture
def lines(chip: Path) -> Iterator[VirtualInputLines]:
    lines = VirtualInputLines(chip)
    yield lines
    lines.close()


def came(lines: VirtualInputLines, count: int) -> list[LineEdge]:
    edges: list[LineEdge] = []

    def enough() -> bool:
        edges.extend(lines.edges().edges)
        return len(edges) >= count

    wait_until("the edges", enough)
    return edges


def test_a_line_that_nobody_drives_has_the_level_of_its_pull(lines: VirtualInputLines) -> None:
    lines.request(BOTH)
    assert lines.levels() == {"A": False, "B": True}


def test_edges_come_in_order_with_the_time_of_their_writer(chip: Path, lines: VirtualInputLines) -> None:
    lines.request(BOTH)
    times = iter((11, 12, 13))
    pins = VirtualPins(chip, clock=lambda: next(times))
    pins.drive({"A": True})
    pins.drive({"A": True, "B": False})
    pins.drive({"A": False})
    expected = [LineEdge(11, "A", True), LineEdge(12, "B", False), LineEdge(13, "A", False)]
    assert came(lines, 3) == expected
    assert lines.levels() == {"A": False, "B": False}


def test_outputs_of_the_same_chip_are_another_claim_and_no_edges(
    chip: Path, lines: VirtualInputLines
) -> None:
    outputs = VirtualLines(chip)
    outputs.request(["OUT"])
    lines.request(BOTH)
    outputs.set({"OUT": True})
    VirtualPins(chip).drive({"OUT": False, "A": True})  # an output is nobody else's to drive
    assert [edge.line for edge in came(lines, 1)] == ["A"]
    assert VirtualChip(chip).read().lines["OUT"] == ("out", True)
    outputs.close()


def test_a_level_counts_once_it_has_stood_for_the_debounce(chip: Path) -> None:
    now = [0]
    lines = VirtualInputLines(chip, clock=lambda: now[0])
    lines.request({"A": DigitalInput(line="A", debounce_ms=5)})
    for at, level in ((1_000, True), (3_000, False), (4_000, True)):
        VirtualPins(chip, clock=lambda at=at: at).drive({"A": level})  # type: ignore[misc]
    now[0] = 4_500

    def due() -> bool:
        assert not lines.edges().edges
        return lines.due() == 9_000

    wait_until("the bounces were seen", due)
    assert lines.levels() == {"A": False}
    now[0] = 9_000
    assert lines.edges().edges == [LineEdge(9_000, "A", True)]
    assert lines.due() is None
    lines.close()


def test_a_pulse_that_is_shorter_than_the_debounce_is_none(chip: Path) -> None:
    now = [0]
    lines = VirtualInputLines(chip, clock=lambda: now[0])
    lines.request({"A": DigitalInput(line="A", debounce_ms=5)})
    for at, level in ((1_000, True), (2_000, False)):
        VirtualPins(chip, clock=lambda at=at: at).drive({"A": level})  # type: ignore[misc]
    now[0] = 3_000

    def due() -> bool:
        lines.edges()
        return lines.due() == 7_000

    wait_until("both were seen", due)
    now[0] = 20_000
    assert lines.edges().edges == []
    lines.close()


def test_a_second_reader_is_refused_with_who_has_them(chip: Path, lines: VirtualInputLines) -> None:
    lines.request(BOTH)
    with pytest.raises(LineBusyError, match=r"an input line of the virtual chip is held by pid \d+"):
        VirtualInputLines(chip).request({"A": A})
    lines.close()
    second = VirtualInputLines(chip)
    second.request({"A": A})
    second.close()


def test_a_line_that_the_chip_has_not(lines: VirtualInputLines) -> None:
    with pytest.raises(LineNotFoundError, match="there is no line C"):
        lines.request({"C": A})
    lines.request(BOTH)  # and nothing stayed claimed


def test_no_chip_then_a_chip_that_vanishes(chip: Path, lines: VirtualInputLines) -> None:
    kept = chip.read_bytes()
    chip.unlink()
    with pytest.raises(WireError, match="there is no virtual chip"):
        lines.request(BOTH)
    chip.write_bytes(kept)
    lines.request(BOTH)
    chip.unlink()
    with pytest.raises(WireError, match="the virtual chip has gone"):
        lines.levels()


def test_more_edges_than_are_kept_are_a_gap_and_the_levels_are_read_anew(
    chip: Path, lines: VirtualInputLines, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines.request(BOTH)
    pins = VirtualPins(chip, clock=now_us)
    for count in range(1500):
        pins.drive({"A": count % 2 == 0})
    pins.drive({"B": False})
    seen = wait_until("the watcher has seen all", lambda: not lines._watcher.state.lines["B"].level)  # type: ignore[union-attr]
    assert seen
    edges, lost = lines.edges()
    assert lost
    assert len(edges) <= 1024
    assert lines.levels() == {"A": False, "B": False}
