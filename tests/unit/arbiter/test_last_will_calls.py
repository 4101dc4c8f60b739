"""How long the ways of a last will and of a write are: counted in calls, for time depends on the machine."""

from __future__ import annotations

import gc
import sys
from collections.abc import Mapping
from types import FrameType

from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.vocabulary import LastWillStep

MOST_CALLS, MOST_WRITE_CALLS = 14, 16
"""A little above what it takes from the noticed death, or a checked message, to the hardware; the session record adds
four.
"""


class Chip:
    """Lines in memory; notes how many calls there were when they were written."""

    def __init__(self) -> None:
        self.calls, self.written = 0, list[int]()

    def request(self, names: list[str]) -> dict[str, bool]:
        return dict.fromkeys(names, False)

    def set(self, levels: Mapping[str, bool]) -> None:
        del levels
        self.written.append(self.calls)

    def levels(self) -> dict[str, bool]:
        return {}

    def close(self) -> None:
        pass

    def count(self, _frame: FrameType, event: str, _what: object) -> None:
        self.calls += event == "call"


def test_a_last_will_is_executed_before_anything_else_is_done() -> None:
    chip = Chip()
    arbiter = LineArbiter(chip, Policy(("A", "B")), 0)
    session = arbiter.hello("grip", "0" * 32, ["A", "B"], (), 1)
    will = (LastWillStep("B"), LastWillStep("A", after_us=1_000_000))
    arbiter.write(session, {"A": True, "B": True}, will, 1_000_000)
    chip.written.clear()
    chip.calls = 0
    gc.disable()  # finalizers of other tests are calls, too
    sys.setprofile(chip.count)
    try:
        arbiter.declare_dead(session, "its socket was closed", 2_000_000)
    finally:
        sys.setprofile(None)
        gc.enable()
    assert arbiter.levels == {"A": True, "B": False}
    assert len(chip.written) == 1
    assert chip.written[0] <= MOST_CALLS
    assert chip.written[0] < chip.calls  # it is told afterwards


def test_a_write_is_done_before_anything_else() -> None:
    chip = Chip()
    policy = Policy(("A", "B"), [("A", "B")], {"B": 1_000_000})
    arbiter = LineArbiter(chip, policy, 0)
    session = arbiter.hello("grip", "0" * 32, ["A"], (), 1)
    gc.disable()
    sys.setprofile(chip.count)
    try:
        arbiter.write(session, {"A": True}, (LastWillStep("A"),), 1_000_000)
    finally:
        sys.setprofile(None)
        gc.enable()
    assert arbiter.levels == {"A": True, "B": False}
    assert chip.written[0] <= MOST_WRITE_CALLS
