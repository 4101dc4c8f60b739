"""Tests that all inputs of the testbench must pass; a test inherits them.

class TestMyInputs(LineInputsConformance):
    @pytest.fixture
    def wires(self, tmp_path):
        yield MyWires(...)
"""

from __future__ import annotations

from queue import Empty, Queue
from typing import Protocol

import pytest

from end_effector_hal.wires import now_us
from end_effector_lab.testbench.inputs import LineInputs

A, B = "SODIMM_206", "SODIMM_208"
LONGEST_S = 20.0


class Wires(Protocol):
    """Test fixture with the lines A and B, both inactive, and a driver for them."""

    inputs: LineInputs

    def drive(self, line: str, level: bool) -> None:
        """Make the line an output, if it is not one, with this level; called after the inputs were started."""
        ...


class LineInputsConformance:
    """Tests of line inputs; the fixture ``wires`` must create new wires for every test, and remove them after it."""

    at_is_now = True
    """Whether edges have times of this machine's monotonic clock."""

    @pytest.fixture
    def seen(self) -> Queue[tuple[str, bool, int]]:
        return Queue()

    def edge(self, seen: Queue[tuple[str, bool, int]]) -> tuple[str, bool]:
        line, level, _ = seen.get(timeout=LONGEST_S)
        return line, level

    def test_begins_with_the_levels_and_no_edge(
        self, wires: Wires, seen: Queue[tuple[str, bool, int]]
    ) -> None:
        assert wires.inputs.start(lambda *edge: seen.put(edge)) == {A: False, B: False}
        wires.inputs.close()
        assert seen.empty()

    def test_tells_each_change_in_order(self, wires: Wires, seen: Queue[tuple[str, bool, int]]) -> None:
        wires.inputs.start(lambda *edge: seen.put(edge))
        for line, level in [(B, True), (A, True), (B, False), (A, False), (A, True)]:
            wires.drive(line, level)
            assert self.edge(seen) == (line, level)
        wires.inputs.close()
        with pytest.raises(Empty):
            seen.get_nowait()

    def test_stamps_a_change_when_it_happens(self, wires: Wires, seen: Queue[tuple[str, bool, int]]) -> None:
        wires.inputs.start(lambda *edge: seen.put(edge))
        stamps = []
        for level in (True, False):
            before = now_us()
            wires.drive(A, level)
            stamps.append(seen.get(timeout=LONGEST_S)[2])
            if self.at_is_now:
                assert before <= stamps[-1] <= now_us()
        assert stamps == sorted(stamps)
        wires.inputs.close()

    def test_what_does_not_change_is_not_told(self, wires: Wires, seen: Queue[tuple[str, bool, int]]) -> None:
        wires.inputs.start(lambda *edge: seen.put(edge))
        wires.drive(A, True)
        assert self.edge(seen) == (A, True)
        wires.drive(A, True)
        wires.drive(B, True)
        assert self.edge(seen) == (B, True)
        wires.inputs.close()

    def test_nothing_is_told_after_the_end(self, wires: Wires, seen: Queue[tuple[str, bool, int]]) -> None:
        wires.inputs.start(lambda *edge: seen.put(edge))
        wires.drive(A, True)
        assert self.edge(seen) == (A, True)
        wires.inputs.close()
        wires.inputs.close()
        assert seen.empty()

    def test_says_what_it_is(self, wires: Wires) -> None:
        assert wires.inputs.text
