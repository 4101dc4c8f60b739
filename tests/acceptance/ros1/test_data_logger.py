"""DataLogger writes as it happens, and goes on where it was."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.recording import (
    AttemptOutcome,
    StatesLog,
    read_pressures,
    read_run,
    read_states,
    read_story,
)
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros


@pytest.fixture
def logger(system: Any, tmp_path: Path) -> Any:
    def start(name: str) -> Any:
        child = system.start(
            name, "rosrun", "end_effector_hal", "data_logger", f"__name:={name}",
            f"_description:={system.world.description_path}", f"_directory:={tmp_path / 'run'}",
        )  # fmt: skip
        system.until("a row", lambda: _is_begun(tmp_path) and rows(tmp_path).rows)
        return child

    return start


def _is_begun(folder: Path) -> bool:
    """Whether the file has its header: it is made empty."""
    path = folder / "run" / "states.csv"
    return path.exists() and path.stat().st_size > 0


def rows(folder: Path) -> StatesLog:
    return read_states(folder / "run" / "states.csv")


def test_a_grip_is_recorded_row_by_row_while_it_happens(system: Any, logger: Any, tmp_path: Path) -> None:
    child = logger("logger_1")
    system.grip()
    system.until("GRIPPED", lambda: rows(tmp_path).rows[-1].end_effector is EndEffectorState.GRIPPED)
    log = rows(tmp_path)
    assert log.columns == ("time_s", "end_effector", "command", "bottom_vacuum", "cylinder", "top_vacuum")
    assert [row.states for row in log.rows] == [
        (6, -1, 0, 0, 0), (1, 2, 0, 0, 0), (1, 2, 1, 0, 0), (1, 2, 2, 0, 0), (1, 2, 2, 1, 0), (1, 2, 2, 2, 0),
        (1, 2, 2, 2, 1), (1, 2, 2, 2, 2), (3, -1, 2, 2, 2),
    ]  # fmt: skip
    (grip,) = read_story(log).grips
    assert [(each.actuator, each.number, each.outcome) for each in grip.attempts] == [
        (name, 1, AttemptOutcome.CONFIRMED) for name in log.actuators
    ]
    assert [event.command for event in log.events or () if event.command] == ["grip"]
    pressures = read_pressures(tmp_path / "run" / "pressures.csv")
    assert pressures.channels == ("bottom", "cylinder", "top", "supply")
    assert min(value for value in pressures.curve("bottom") if value is not None) < -55
    info = read_run(tmp_path / "run")
    assert (info.ros, info.simulated, info.description) == (True, True, "verdin_gripper")
    assert info.limits["cylinder"]["confirmed_kpa"] == pytest.approx(510)
    child.end()
    assert child.code is not None


def test_a_killed_logger_loses_nothing_and_the_next_goes_on(system: Any, logger: Any, tmp_path: Path) -> None:
    child = logger("logger_2")
    system.grip()
    system.until("GRIPPED", lambda: rows(tmp_path).rows[-1].end_effector is EndEffectorState.GRIPPED)
    before = rows(tmp_path)
    child.end(signal_number=9)
    assert rows(tmp_path).rows == before.rows
    system.run("Drop")
    again = logger("logger_3")
    system.until("STAND_BY", lambda: rows(tmp_path).rows[-1].end_effector is EndEffectorState.STAND_BY)
    after = rows(tmp_path)
    assert after.rows[: len(before.rows)] == before.rows
    assert 0.5 < after.rows[-1].time_s - before.rows[-1].time_s < 60.0
    again.end()


def test_the_launch_file_records_where_it_is_told_to(system: Any) -> None:
    log = read_states(system.folder / "log" / "states.csv")
    assert log.rows[0].end_effector in (EndEffectorState.OFF, EndEffectorState.STAND_BY)
