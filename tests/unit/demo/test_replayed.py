"""The demo replays what it recorded: a run without its trace, or with another, is not ok."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.description import Description
from end_effector_lab.demo._agreement import answered, replayed
from tests.support.recorded_tool import RecordedTool, recorded


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return recorded(tmp_path, "nominal", 1.0, "grip", 2.0)


def test_a_run_that_decides_the_same_is_ok(folder: Path) -> None:
    assert replayed(folder).ok


def test_another_decision_is_a_fault_with_its_time(folder: Path) -> None:
    path = folder / "hal.mcap"
    data = path.read_bytes()
    changed = data.replace(b'"name":"grip"', b'"name":"drop"', 1)
    assert changed != data
    path.write_bytes(changed)
    finding = replayed(folder)
    assert not finding.ok
    assert finding.found.startswith("hal.mcap at 1.000 s: ")


@pytest.mark.parametrize("codec", ["ees1-ascii", "legacy-nibble"])
def test_a_command_that_was_refused_is_told_with_its_reason(
    verdin: Description, tmp_path: Path, codec: str
) -> None:
    link = verdin.link.model_copy(update={"codec": codec})
    tool = RecordedTool(tmp_path, description=verdin.model_copy(update={"link": link}))
    tool.run(8.0)
    tool.command("unlock")
    tool.close()
    refused = (
        "unlock was refused: IL-02: no sensor shows where the tool is: arm first, then unlock within 10 s."
    )
    assert answered(tmp_path).found == ("every command taken" if codec == "ees1-ascii" else refused)
    assert answered(tmp_path).ok is (codec == "ees1-ascii")


def test_no_trace_is_a_fault(tmp_path: Path) -> None:
    finding = replayed(tmp_path)
    assert not finding.ok
    assert "no trace here" in finding.found
