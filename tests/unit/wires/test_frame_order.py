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
    assert order.next(frame(120_000), waits_us=30_000).at == 160_000
    assert order.next(frame(109_000), waits_us=30_000).at == 109_000


def test_what_waited_while_the_machine_was_late_keeps_its_order_and_its_age() -> None:
    order = FrameOrder()
    order.next(frame(100_000), "board")
    came = [20_000, 40_000, 60_000, 85_000, 86_000]
    assert [order.next(frame(at), "link").at for at in came] == [20_000, 40_000, 60_000, 100_000, 100_000]
    order.next(frame(140_000), "board")
    # 90 ms is not within moments of the newest, and stays behind what this source was given before
    assert [order.next(frame(at), "link").at for at in (90_000, 119_000)] == [100_000, 119_000]


def test_moments_do_not_add_up_for_a_source_that_goes_back() -> None:
    order = FrameOrder()
    order.next(frame(100_000), "link")
    assert [order.next(frame(at), "link").at for at in (85_000, 79_999)] == [100_000, 79_999]
