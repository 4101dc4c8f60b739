"""The bus of the shipped example of a 2F-85."""

from __future__ import annotations

import pytest

from tests.support.robotiq import Gripper2F85
from tests.unit.wires.bus.played_bus import (
    Bus,
    example,
)


@pytest.fixture
def gripper() -> Gripper2F85:
    return Gripper2F85()


@pytest.fixture
def bus(gripper: Gripper2F85) -> Bus:
    return Bus(example("gripper_2f85"), {9: gripper})
