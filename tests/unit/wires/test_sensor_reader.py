"""What several sources deliver stands in one order of time; what waited too long keeps its own stamp."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.wires.sensors import SensorReader

S, MS = 1_000_000, 1_000


def test_only_a_frame_that_was_overtaken_by_moments_is_moved(verdin: Description) -> None:
    heard: list[int] = []
    reader = SensorReader(verdin, lambda frame: heard.append(frame.at))
    # the third and fourth: a relay's backlog, after this process has stood still
    for at in (10 * S, 10 * S - 5 * MS, 5 * S, 5 * S + 20 * MS, 10 * S + 1 * MS):
        reader._deliver(Frame(at, None, None, {}))
    assert heard == [10 * S, 10 * S, 5 * S, 5 * S + 20 * MS, 10 * S + 1 * MS]
