from __future__ import annotations

from end_effector_lab.testbench.physics import ToolChanger, Valve


def test_inactive_is_locked_active_is_unlocked_and_between_is_neither() -> None:
    changer = ToolChanger(Valve(30_000))
    changer.advance(1_000_000)
    assert changer.bits == {"locked": True, "unlocked": False}
    changer.command(True, 1_000_000)
    changer.advance(1_100_000)
    assert changer.bits == {"locked": False, "unlocked": False}
    changer.advance(1_200_000)
    assert changer.bits == {"locked": False, "unlocked": True}
    changer.command(False, 2_000_000)
    changer.advance(2_100_000)
    assert changer.bits == {"locked": False, "unlocked": False}
    changer.advance(2_200_000)
    assert changer.bits == {"locked": True, "unlocked": False}
    assert changer.pressure_kpa is None
