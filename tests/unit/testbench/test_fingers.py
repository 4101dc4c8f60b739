"""Fingers close on the part that is there, and as far as they go without one."""

from __future__ import annotations

import pytest

from end_effector_lab.testbench.physics import STEP_US, Fingers, HoldingMagnet

OPEN, CLOSED, PART, BETWEEN = {"open"}, {"closed"}, {"part"}, set[str]()


def shown(device: Fingers | HoldingMagnet) -> set[str]:
    return {name for name, on in device.bits.items() if on}


def story(fingers: Fingers, seconds: float) -> list[set[str]]:
    """What the switches show, one after the other."""
    seen = [shown(fingers)]
    for at in range(fingers.now, fingers.now + round(seconds * 1e6), STEP_US):
        fingers.advance(at)
        if shown(fingers) != seen[-1]:
            seen.append(shown(fingers))
    return seen


def test_on_their_way_no_switch_is_made() -> None:
    fingers = Fingers()
    fingers.command(True, 0)
    assert story(fingers, 1.0) == [OPEN, BETWEEN, PART]
    fingers.command(False, fingers.now)
    assert story(fingers, 1.0) == [PART, BETWEEN, OPEN]


def test_without_a_part_they_close_as_far_as_they_go() -> None:
    fingers = Fingers()
    fingers.meet(False)
    fingers.command(True, 0)
    assert story(fingers, 1.0) == [OPEN, BETWEEN, CLOSED]


def test_a_part_that_is_pulled_out_is_back_for_the_next_grip() -> None:
    fingers = Fingers()
    fingers.settle(True)
    assert shown(fingers) == PART
    fingers.lose(0)
    assert story(fingers, 1.0) == [BETWEEN, CLOSED]
    for active in (False, True):
        fingers.command(active, fingers.now)
        fingers.advance(fingers.now + 1_000_000)
    assert shown(fingers) == PART


@pytest.mark.parametrize(("after_ms", "holds"), [(100, True), (200, False)])
def test_a_magnet_that_is_switched_off_holds_for_a_while(after_ms: int, holds: bool) -> None:
    magnet = HoldingMagnet()
    magnet.settle(True)
    magnet.command(False, 0)
    magnet.advance(after_ms * 1000)
    assert shown(magnet) == ({"part"} if holds else {"gone"})


def test_a_magnet_holds_nothing_where_there_is_nothing_or_it_is_torn_off() -> None:
    magnet = HoldingMagnet()
    magnet.meet(False)
    magnet.command(True, 0)
    magnet.advance(1_000_000)
    assert shown(magnet) == {"gone"}
    magnet.meet(True)
    magnet.advance(1_100_000)
    assert shown(magnet) == {"part"}
    magnet.lose(1_100_000)
    magnet.advance(2_000_000)
    assert shown(magnet) == {"gone"}
