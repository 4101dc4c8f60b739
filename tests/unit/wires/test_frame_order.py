"""The order of the frames of several readers, or of edges and the levels that overtake them."""

from __future__ import annotations

from end_effector_hal.signals import Frame
from end_effector_hal.wires.sensors import FrameOrder


def frame(at: int) -> Frame:
    return Frame(at, None, None, {"e_stop": False})


def test_what_was_overtaken_a_little_is_judged_after_what_overtook_it() -> None:
    order = FrameOrder()
    came = [100_000, 99_990, 120_000, 100_000, 99_999, 130_000]
    assert [order.next(frame(at)).at for at in came] == [100_000, 100_000, 120_000, 120_000, 99_999, 130_000]


def test_a_cycle_that_ended_in_waiting_for_a_dead_device_still_counts() -> None:
    order = FrameOrder()
    order.next(frame(160_000))
    assert order.next(frame(120_000), 30_000).at == 160_000
    assert order.next(frame(109_000), 30_000).at == 109_000
