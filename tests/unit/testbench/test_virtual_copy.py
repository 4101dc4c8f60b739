"""A tool without hardware: the copy that the testbench and every program of a simulation read."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.arbiter import output_lines
from end_effector_hal.cli.doctor._lines import look_at_lines
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.commands._testbench import command
from end_effector_lab.testbench import open_inputs, write_virtual_copy
from end_effector_lab.testbench.inputs import VirtualInputs
from tests.support.places import ROOT

TOOLS = ROOT / "examples/tools"


def test_the_copy_is_the_same_tool_with_its_own_wires_beside_it(tmp_path: Path) -> None:
    folder = tmp_path / "simulated"
    done = CliRunner().invoke(command, ["--prepare", str(folder)], catch_exceptions=False)
    path = Path(done.stdout.strip())
    copy, tool = load(path), load(profile_path())
    assert path == folder / "end_effector.yaml"
    assert (copy.lines.backend, copy.link.port) == ("virtual", str(folder / "uart"))
    assert copy.automata_path == tool.automata_path
    assert (copy.actuators, copy.sequence, copy.bounds) == (tool.actuators, tool.sequence, tool.bounds)
    # the line arbiter may start before the testbench
    (finding,) = look_at_lines(copy, output_lines(copy))
    assert finding.level.value == "ok", finding


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="Cannot be made: it is a link, or no directory"):
        write_virtual_copy(load(profile_path()), tmp_path / "file" / "folder")


@pytest.mark.parametrize("name", ["gripper_2f85", "double_acting_jaw", "diy_vacuum", "two_epick"])
def test_the_chip_of_the_copy_is_the_one_that_the_testbench_wants(name: str, tmp_path: Path) -> None:
    copy = load_tool(write_virtual_copy(load_tool(TOOLS / name / "end_effector.yaml"), tmp_path))
    inputs = open_inputs(None, copy)
    levels = inputs.start(lambda line, level, at: None)
    inputs.close()
    assert not any(levels.values())


def test_the_sensors_show_their_levels_before_the_testbench_plays(tmp_path: Path) -> None:
    """The first reader of the chip finds an e-stop that is active low closed."""
    copy = load_tool(write_virtual_copy(load_tool(TOOLS / "double_acting_jaw/end_effector.yaml"), tmp_path))
    levels = {"GPIO17": False, "GPIO27": True, "GPIO22": False}  # open, not closed, no stop; inverted
    chip = read_chip(tmp_path / "chip").lines
    assert {line: chip[line] for line in levels} == {line: ("in", each) for line, each in levels.items()}
    opened = open_inputs(None, copy, power_cycle=True, scenario="estop-open")
    assert isinstance(opened, VirtualInputs)
    assert opened.make_chip().read().lines["GPIO22"].level
