"""The time left that a status tells is that of the gripping, whatever else is due."""

from __future__ import annotations

from end_effector_hal.description import load, profile_path
from end_effector_lab.virtual import VirtualTool


def test_an_arming_that_expires_is_not_the_time_left_of_a_grip() -> None:
    tool = load(profile_path())
    changer = tool.tool_changer
    assert changer is not None
    armed = tool.model_copy(
        update={"tool_changer": changer.model_copy(update={"stand_bit": "none", "arm_s": 3.0})}
    )
    played = VirtualTool(armed, "never-confirms:bottom_vacuum")
    played.run(1.0)
    assert played.command("arm").accepted
    begun = played.at
    assert played.command("grip").accepted
    timeout_s = armed.actuators["bottom_vacuum"].timeout_s
    assert played.status.armed
    assert played.status.deadline == begun + round(timeout_s * 1e6)
