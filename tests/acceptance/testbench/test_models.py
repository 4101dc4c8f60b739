"""Simulated devices, commanded by a driver that others wrote and by the whole product, over a pseudo-terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyrobotiqgripper
import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from end_effector_lab.testbench import Testbench, chosen_models, open_inputs, open_ports, write_virtual_copy
from tests.support.patience import wait_until
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
GRIPPER = ROOT / "examples/tools/gripper_2f85/end_effector.yaml"
MODEL = "9=robotiq-2f85"


@contextmanager
def simulated(folder: Path) -> Iterator[tuple[Testbench, str]]:
    """A testbench in this process, and the port of its bus."""
    tool = load_tool(write_virtual_copy(load_tool(GRIPPER), folder))
    inputs, ports = open_inputs(None, tool), open_ports(None, tool, None)
    with Testbench(tool, inputs, ports, models=chosen_models(MODEL, tool)) as bench:
        yield bench, tool.link.port


def test_a_driver_that_others_wrote_activates_moves_grips_and_reads_it(tmp_path: Path) -> None:
    with simulated(tmp_path) as (bench, port):
        gripper = pyrobotiqgripper.RobotiqGripper(com_port=port)
        try:
            with pytest.raises(pyrobotiqgripper.GripperNotActivatedError):
                gripper.move(100)
            gripper.activate()
            assert gripper.isActivated()
            assert gripper.position() == 3
            gripper.move(100)
            assert (gripper.position(), gripper.objectDetection()) == (100, 3)
            gripper.close()
            assert gripper.objectDetection() == 2
            assert gripper.position() == 139
            bench.choose("no-part:fingers")
            wait_until("the fingers go on", lambda: gripper.objectDetection() == 3)
            assert gripper.position() == 230
            gripper.open()
            assert (gripper.position(), gripper.objectDetection()) == (3, 3)
            gripper.reset()
            assert not gripper.isActivated()
        finally:
            gripper.disconnect()


@pytest.mark.thinned
def test_the_product_grips_loses_and_drops_with_it(tmp_path: Path) -> None:
    with World(load_tool(GRIPPER), "nominal", tmp_path, models=MODEL) as world:
        assert f"unit 9 plays {MODEL[2:]} by its manual" in world.testbench.text()
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(30)
            assert tool.grip().succeeded
            world.choose("lost-after:fingers:0.1")
            wait_until("the loss", lambda: tool.status.ee == EndEffectorState.GRIP_ERROR)
            world.choose("nominal")
            assert tool.drop().succeeded
            assert tool.grip().succeeded
            world.choose("reboot-after:0")
            wait_until(
                "it is not activated", lambda: "not activated any more" in " ".join(tool.status.alarm_texts)
            )
            assert tool.drop().succeeded
