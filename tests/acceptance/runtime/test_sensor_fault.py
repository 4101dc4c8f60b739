"""A sensor fault of the tool changer stays latched through the death of its program: the line arbiter keeps it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import ChangerProgram, Program, open_program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerFault, ChangerState
from end_effector_hal.wires import now_us
from end_effector_lab.demo._world import World
from tests.support.patience import PATIENCE_S

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]
PRESSURES = {"bottom": 0.0, "cylinder": 0.0, "top": 0.0, "supply": 600_000.0}


@pytest.fixture
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with World(load(profile_path()), "nominal", tmp_path_factory.mktemp("world")) as running:
        yield running


def fed(program: Program, until: Callable[[Status], bool], *, unlocked: bool) -> Status:
    """Frames of a locked tool, whose other bit is as given, until a status is as wanted."""
    end = time.monotonic() + PATIENCE_S
    while not until(program.status):
        assert time.monotonic() < end, program.status
        bits = {"locked": True, "unlocked": unlocked}
        program.frame(Frame(now_us(), None, None, {**PRESSURES, **bits}))
        time.sleep(0.02)
    return program.status


def faults(world: World) -> set[str]:
    with ArbiterClient(world.socket, "look") as look:
        return set(look.status()["faults"])


def test_a_sensor_fault_is_there_again_after_a_restart_until_a_reset(world: World) -> None:
    first = open_program(ChangerProgram, world.description)
    first.start()
    fed(first, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    assert not faults(world)
    status = fed(first, lambda status: status.changer == ChangerState.FAULT, unlocked=True)
    assert status.changer_fault == ChangerFault.SENSOR
    assert faults(world) == {"sensor_fault"}
    first.close()

    second = open_program(ChangerProgram, world.description)
    second.start()
    status = fed(second, lambda status: status.changer != ChangerState.UNKNOWN, unlocked=False)
    assert (status.changer, status.changer_fault) == (ChangerState.FAULT, ChangerFault.SENSOR)
    fed(second, lambda status: "sensor fault" in " ".join(status.alarms), unlocked=False)
    with ArbiterClient(world.socket, "reset") as owner:
        assert owner.reset() == {
            "sensor_fault": "tool_change has latched sensor_fault, and has not been reset."
        }
    assert faults(world) == {"sensor_fault"}
    assert second.command("reset").accepted
    assert not faults(world), "the program has cleared it before it answers"
    fed(second, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    assert not faults(world)
    second.close()

    third = open_program(ChangerProgram, world.description)
    third.start()
    fed(third, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    third.close()
