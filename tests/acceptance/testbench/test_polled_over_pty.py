"""A device that is asked: LinkReader and testbench as they are, over a pty."""

from __future__ import annotations

from pathlib import Path
from queue import Queue

import pytest

from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualLines
from end_effector_hal.wires.link._reader import LinkReader
from end_effector_lab.testbench import Testbench
from end_effector_lab.testbench._ports import PtyPort
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.support.patience import PATIENCE_S


@pytest.mark.wall
def test_pressures_are_read_and_a_silent_device_is_asked_again(tmp_path: Path, verdin: Description) -> None:
    codec = "modbus-rtu-transmitters"
    tool = verdin.model_copy(update={"link": verdin.link.model_copy(update={"codec": codec})})
    port, chip = str(tmp_path / "uart"), tmp_path / "chip"
    inputs = VirtualInputs(chip, ["SODIMM_206", "SODIMM_208", "SODIMM_210", "SODIMM_212"])
    frames: Queue[Frame] = Queue()
    with (
        Testbench(tool, inputs, PtyPort(port)) as bench,
        LinkReader(port, codec, on_frame=frames.put) as link,
    ):
        assert frames.get(timeout=PATIENCE_S).values["supply"] == pytest.approx(600_000, abs=2_000)
        lines = VirtualLines(chip)
        lines.request(["SODIMM_208"])
        lines.set({"SODIMM_208": True})
        while (frames.get(timeout=PATIENCE_S).values["bottom"] or 0) > -55_000:
            pass
        bench.choose("silent-after:0")
        while not link.health.errors.get("timeout"):
            pass
        bench.choose("invalid:top_vacuum")
        while frames.get(timeout=PATIENCE_S).values["top"] is not None:
            pass
        lines.close()
