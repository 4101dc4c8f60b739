"""A tool without hardware: the copy that the testbench and every program of a simulation read."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.arbitration import output_lines
from end_effector_hal.cli.doctor._lines import look_at_lines
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_lab.commands._testbench import command
from end_effector_lab.testbench import write_virtual_copy


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
    with pytest.raises(UsageError, match="Cannot be made: Not a directory"):
        write_virtual_copy(load(profile_path()), tmp_path / "file" / "folder")
