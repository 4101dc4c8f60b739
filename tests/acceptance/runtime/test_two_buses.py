"""Two grippers on two buses of their own, with real processes; when one bus dies the other goes on."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import Description, examine_text
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.acceptance.runtime.test_commanded_gripper import Cable
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.robotiq import Gripper2F85

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
READY_S = 30.0
SIDES = ("left", "right")
LEFT, RIGHT = "modbus:left:9/0x03E8", "modbus:right:9/0x03E8"
CHANNELS = """
  {side}_ready: {{link: {side}, modbus: {{unit: 9, address: 0x07D0, bitmask: 0x3000}}, on: [3]}}
  {side}_told: {{link: {side}, modbus: {{unit: 9, address: 0x07D1, bitmask: 0x00FF}}, on: [0xFF]}}
  {side}_part: {{link: {side}, modbus: {{unit: 9, address: 0x07D0, bitmask: 0xC800}}, on: [0x11]}}
  {side}_open: {{link: {side}, modbus: {{unit: 9, address: 0x07D2, bitmask: 0xFF00}}, on: [0, 1, 2, 3]}}
"""
ACTUATOR = """
  {side}:
    kind: gripper
    modbus:
      link: {side}
      unit: 9
      address: 0x03E8
      command_on: [0x0900, 0x00FF, 0xFFFF]
      command_off: [0x0900, 0x0000, 0xFFFF]
      verify: {side}_told
      activation: {{write: [[0, 0, 0], [0x0100, 0, 0]], ready: {side}_ready, ready_within_s: 4}}
    part_bit: {side}_part
    open_bit: {side}_open
    timeout_s: 6
    service: Set{side}
"""


def two_buses(ports: dict[str, str]) -> Description:
    """The same gripper twice, the same unit and registers, each on a bus of its own."""
    links = "\n".join(
        f"  {side}: {{port: {ports[side]}, baudrate: 115200, period_ms: 20, frame: {{modbus: {{}}}}}}"
        for side in SIDES
    )
    channels = "".join(CHANNELS.format(side=side) for side in SIDES)
    actuators = "".join(ACTUATOR.format(side=side) for side in SIDES)
    examined = examine_text(
        f"schema: 2\nname: two_buses\nlinks:\n{links}\nchannels:{channels}\nsequence: [left, right]\n"
        f"actuators:{actuators}\nsupply: {{channel: none}}\n",
        "tool.yaml",
    )
    assert examined.description is not None, examined.lines()
    return examined.description


class Rig:
    """Two cables, and the line arbiter that masters both."""

    def __init__(self, folder: Path) -> None:
        self.cables: dict[str, Cable] = {}
        for side in SIDES:
            (folder / side).mkdir()
            self.cables[side] = Cable(folder / side, Gripper2F85(now_us()))
        tool = two_buses({side: cable.port for side, cable in self.cables.items()})
        virtual = tool.lines.model_copy(update={"backend": "virtual", "path": str(folder / "chip")})
        tool = tool.model_copy(update={"lines": virtual})
        self.folder, self.world = folder, World(tool, "nominal", folder, own_wires=True)

    def __enter__(self) -> Rig:
        self.world.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.world.__exit__(*error)
        for cable in self.cables.values():
            cable.close()

    def levels(self) -> dict[str, bool]:
        with ArbiterClient(self.world.socket, "look") as look:
            return dict(look.levels())


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    with Rig(tmp_path) as running:
        yield running


def test_both_grip_and_let_go_and_each_bus_has_a_relay_of_its_own(rig: Rig) -> None:
    with EndEffector.open(rig.world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("a grip", lambda: tool.grip().succeeded)
        assert all(cable.device.holds for cable in rig.cables.values())
        assert rig.levels() == {LEFT: True, RIGHT: True}
        relays = {path.name for path in rig.world.socket.parent.glob("*.bus.*")}
        assert relays == {f"{rig.world.socket.name}.bus.{side}" for side in SIDES}
        assert tool.drop().succeeded
        assert not any(cable.device.holds for cable in rig.cables.values())


def test_one_that_dies_is_told_and_the_other_is_read_and_commanded_on(rig: Rig) -> None:
    left, right = rig.cables["left"], rig.cables["right"]
    with EndEffector.open(rig.world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("a grip", lambda: tool.grip().succeeded)
        left.cut = True
        wait_until("the alarm", lambda: any("left" in alarm for alarm in tool.status.alarm_texts))
        assert tool.status.ee == EndEffectorState.GRIPPED
        frames = tool.links["right"].frames
        wait_until("the other is read", lambda: tool.links["right"].frames > frames + 10)
        assert not tool.drop().succeeded  # of the left one nothing is proven
        wait_until("the other has let go", lambda: not right.device.holds)
        assert left.device.holds
        left.cut = False
        wait_until("it lets go once it hears", lambda: not left.device.holds)
        wait_until(
            "it is proven", lambda: tool.drop().succeeded or tool.status.ee == EndEffectorState.STAND_BY
        )


def test_a_port_that_is_gone_keeps_only_its_own_gripper_from_the_next_arbiter(rig: Rig) -> None:
    with EndEffector.open(rig.world.description) as tool:
        tool.wait_ready(READY_S)
        wait_until("a grip", lambda: tool.grip().succeeded)
        with ArbiterClient(rig.world.socket, "test") as observer:
            os.kill(observer.status()["pid"], signal.SIGKILL)
    written = {side: len(cable.device.written) for side, cable in rig.cables.items()}
    Path(rig.cables["left"].port).unlink()
    again = rig.world.children.start(
        "again", [*EEHAL, "arbiter", str(rig.world.description_path)], log=rig.folder / "again.log"
    )
    again.wait_until(lambda: "serving:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
    assert f"{RIGHT}=1" in again.text()
    assert {side: len(cable.device.written) for side, cable in rig.cables.items()} == written
    assert all(cable.device.holds for cable in rig.cables.values())
