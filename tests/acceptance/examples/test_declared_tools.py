"""The tools of examples/tools whose frames are declared: checked, proved, played over a pty and replayed."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from queue import Queue

import pytest

from end_effector_hal.cli.doctor._check_result import Level
from end_effector_hal.cli.doctor._link import look_at_link
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualLines
from end_effector_hal.wires.link import PtyPair
from end_effector_hal.wires.sensors import SensorReader
from end_effector_lab.testbench import Testbench
from end_effector_lab.testbench._ports import PtyPort
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.support.command import eehal, eehal_here
from tests.support.nightly import first_of
from tests.support.patience import PATIENCE_S
from tests.unit.virtual.test_asked_tool import ASKED

from .conftest import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
TOOLS = ROOT / "examples" / "tools"
DECLARED = ("diy_text", "two_epick", "diy_record")
COMMANDED = ("gripper_2f85", "epick_commanded", "remote_io", "remote_changer")


@pytest.mark.parametrize("name", first_of(COMMANDED[:1] + DECLARED + COMMANDED[1:], 1, 2))
def test_it_is_checked_and_proved(name: str) -> None:
    tool = TOOLS / name / "end_effector.yaml"
    assert eehal_here("check", tool).startswith(name)
    proof = json.loads(eehal_here("verify", tool, "--json"))
    assert all(each["holds"] for each in proof["requirements"])


@pytest.mark.parametrize("name", first_of(DECLARED, 0, 1) + first_of(COMMANDED, 1, 0))
def test_it_grips_and_its_recording_decides_the_same(name: str, tmp_path: Path) -> None:
    tool = TOOLS / name / "end_effector.yaml"
    eehal("demo", tool, "--no-ros", "--only", "nominal", "-o", tmp_path)
    told = json.loads(eehal_here("plot", tmp_path / "nominal", "-o", tmp_path / "again.svg", "--json"))
    assert told["verdict"] == "Nominal: GRIPPED, then dropped"
    eehal_here("replay", tmp_path / "nominal")


def on_virtual_wires(name: str, folder: Path) -> tuple[Description, VirtualInputs]:
    path = TOOLS / name / "end_effector.yaml"
    if name == "asked":
        path = folder / "tool.yaml"
        path.write_text(ASKED)
    tool = load_tool(path).with_virtual(folder / "chip", f"{folder}/uart")
    return tool, VirtualInputs(folder / "chip", [each.line for _, each in tool.ordered])


@pytest.mark.parametrize("name", [*DECLARED, "asked"])
def test_the_doctor_listens_and_the_testbench_shows_what_the_lines_do(name: str, tmp_path: Path) -> None:
    tool, inputs = on_virtual_wires(name, tmp_path)
    frames: Queue[Frame] = Queue()
    with Testbench(tool, inputs, PtyPort(tool.link.port)):  # type: ignore[union-attr]
        (said,) = look_at_link(tool)
        assert said.level is Level.OK, said
        assert "the declared frame" in said.what
        reader = SensorReader(tool, frames.put)
        reader.start()
        cup = next(actuator for actuator in tool.actuators.values() if actuator.kind == "vacuum")
        lines = VirtualLines(tmp_path / "chip")
        lines.request([cup.line])
        lines.set({cup.line: True})
        while (frames.get(timeout=PATIENCE_S).values[cup.channel] or 0) > -55_000:
            pass
        lines.close()
        reader.close()


def test_the_doctor_says_what_to_look_at_where_nothing_fits(tmp_path: Path) -> None:
    tool, _ = on_virtual_wires("diy_text", tmp_path)
    with PtyPair(tool.link.port) as pty:  # type: ignore[union-attr]
        stop = threading.Event()

        def babble() -> None:
            while not stop.wait(0.01):
                pty.write(b"boot 1.2.3\r\n")

        thread = threading.Thread(target=babble)
        thread.start()
        (said,) = look_at_link(tool)
        stop.set()
        thread.join()
    assert "bytes and no frame" in said.what + said.todo
    assert "link.frame and voltage levels" in said.what + said.todo
