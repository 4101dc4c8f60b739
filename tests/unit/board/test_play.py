"""What becomes of what the board left; without the board."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import StatesWriter, run_info
from end_effector_lab.demo import scenarios
from end_effector_lab.testbench._program import Events
from tools.board import BoardError, Ended, play_on_board
from tools.board import _play as module

TOOL = load(profile_path())
NOMINAL = scenarios(TOOL)[0]
Left = Callable[[Path], Ended]


@pytest.fixture
def play(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Left], Any]:
    """Plays the first scenario on a board that leaves what the test says."""

    def play(left: Left) -> Any:
        def run_board(parts: Path, folder: Path, job: str, **options: Any) -> Ended:
            assert f"--own-wires --no-figures --only {NOMINAL.name} --no-ros -o /run/results" in job
            assert options["testbench"] == [str(TOOL.source), "--scenario", "nominal"]
            assert set(options["files"]) == {
                "opt/end-effector/tool/end_effector.yaml",
                "opt/end-effector/tool/end_effector.xml",
            }
            return left(folder)

        monkeypatch.setattr(module, "run_board", run_board)
        return play_on_board(NOMINAL, TOOL, tmp_path, tmp_path / "run", ros=False, figures=False)

    return play


def at_rest(folder: Path) -> Ended:
    """A recording in which nothing happens."""
    recorded = folder / "results" / NOMINAL.name
    (recorded / "ros").mkdir(parents=True)
    (recorded / "ros" / "latest").symlink_to("/run/results/nominal/ros/1")
    run_info(TOOL, scenario="nominal", ros=False).write(recorded)
    writer = StatesWriter(recorded / "states.csv", TOOL.sequence)
    writer.write(0.0, 0, -1, [0, 0, 0])
    writer.write(1.0, 6, -1, [0, 0, 0])
    writer.close()
    events = Events(folder / "events")
    events.line("SODIMM_208", True, 100, 100)
    events.close()
    return Ended(1, "it said this", 12.5)


def test_a_recording_comes_home_and_is_judged_by_the_pins(
    play: Callable[[Left], Any], tmp_path: Path
) -> None:
    played = play(at_rest)
    assert (played.seconds, played.folder) == (12.5, tmp_path / "run")
    faults = [fault.partition(":")[0] for fault in played.faults]
    assert faults == ["states", "commands", "attempts", "wires", "answers", "replay"]
    names = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"states.csv", "run.json", "events", "end_effector.yaml", "ros"} <= names
    assert (tmp_path / "run" / "ros" / "latest").is_symlink()


def test_the_same_folder_again(play: Callable[[Left], Any], tmp_path: Path) -> None:
    play(at_rest)
    (tmp_path / "run" / "old").write_text("")
    play(at_rest)
    assert not (tmp_path / "run" / "old").exists()


def test_a_folder_of_somebody_else(play: Callable[[Left], Any], tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "thesis.txt").write_text("")
    with pytest.raises(UsageError, match="did not write"):
        play(at_rest)


@pytest.mark.parametrize("code", [None, 2, 3, 0])
def test_a_board_that_leaves_no_recording(play: Callable[[Left], Any], code: int | None) -> None:
    with pytest.raises(BoardError, match=r"left no recording in .*/run; it said:\n    kernel panic"):
        play(lambda folder: Ended(code, "kernel panic\n", 1.0))
