"""The differences of two recordings: what is aligned, what is told, and what is no difference."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import (
    BEGUN,
    AlarmRow,
    PressuresLog,
    RunDifference,
    RunTables,
    StatesLog,
    Tolerances,
    compare_runs,
)
from end_effector_lab.commands._compare import read_tables
from tests.support.trace_recordings import FAILS_ONCE, INFO, NOMINAL, PRESSURES, log, written


def later(run: RunTables, by_s: float) -> RunTables:
    """The same on another clock, seconds later."""
    pressures = run.pressures and replace(
        run.pressures, samples=tuple((at + by_s, values) for at, values in run.pressures.samples)
    )
    return RunTables(
        replace(run.log, rows=tuple(replace(row, time_s=row.time_s + by_s) for row in run.log.rows)),
        run.info,
        pressures,
        tuple(replace(row, time_s=row.time_s + by_s) for row in run.changer),
        tuple(replace(row, time_s=row.time_s + by_s) for row in run.alarms),
    )


def tables(states: StatesLog, pressures: PressuresLog | None = None, *alarms: AlarmRow) -> RunTables:
    return RunTables(states, INFO, pressures, (), alarms)


def told(first: RunTables, second: RunTables, tolerances: Tolerances | None = None) -> list[tuple[str, str]]:
    return [(each.line, each.text) for each in compare_runs(first, second, tolerances)]


def test_a_run_has_no_difference_from_itself_whenever_it_began() -> None:
    run = tables(NOMINAL, PRESSURES, AlarmRow(3.0, BEGUN, "Leak: 3 kPa"))
    assert told(run, run) == told(run, later(run, 7.0)) == told(later(run, 7.0), run) == []


def test_a_time_out_more_is_told_once() -> None:
    """What comes after it is six seconds later altogether: only the first of it is told."""
    assert compare_runs(tables(NOMINAL), tables(FAILS_ONCE)) == [
        RunDifference("cylinder", "EXTENDED: 6.25 s later in the second", 2.0, 8.25),
        RunDifference("cylinder", "RETRACTED: only in the second", None, 6.5),
        RunDifference("cylinder", "PENDING EXTEND: only in the second", None, 7.5),
        RunDifference("end_effector", "RELEASING: 6.25 s earlier in the second", 11.0, 11.0),
    ]


def test_the_other_way_round_it_is_the_other_way_round() -> None:
    assert ("cylinder", "RETRACTED: only in the first") in told(tables(FAILS_ONCE), tables(NOMINAL))


def test_what_is_later_than_the_tolerance_is_told() -> None:
    slower = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), (1.9, 3, -1, 2), names=["a_vacuum"])
    quicker = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), (1.5, 3, -1, 2), names=["a_vacuum"])
    run, other = replace(tables(quicker), info=replace(INFO, actuators={})), tables(slower)
    assert told(run, other) == [("end_effector", "GRIPPED: 0.40 s later in the second")]
    assert told(run, other, Tolerances(seconds=0.5)) == []


def test_numbers_in_an_alarm_are_no_difference_and_a_further_alarm_is() -> None:
    leak, other = AlarmRow(3.0, BEGUN, "Leak: 1.5 kPa/s"), AlarmRow(3.0, BEGUN, "Leak: 2 kPa/s")
    assert told(tables(NOMINAL, None, leak), tables(NOMINAL, None, other)) == []
    more = tables(NOMINAL, None, other, AlarmRow(4.0, BEGUN, "Late."))
    assert told(tables(NOMINAL, None, leak), more) == [("alarms", "Late.: only in the second")]


def test_an_actuator_of_one_only() -> None:
    alone = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), names=["bottom_vacuum"])
    both = log((0.0, 6, -1, 0, 0), (1.0, 1, 2, 1, 0), names=["bottom_vacuum", "cylinder"])
    assert told(tables(alone), tables(both)) == [("cylinder", "only the second recording has it")]


def curve(*samples: tuple[float, float | None]) -> PressuresLog:
    return PressuresLog(("bottom",), tuple((at, (value,)) for at, value in samples))


STEPS = [(i / 10, 0.0 if i < 15 else -60.0) for i in range(40)]


def test_a_pressure_that_is_apart_is_told_with_how_much_and_how_long() -> None:
    lower = [(at, value - 8.0 if 2.0 <= at <= 3.0 else value) for at, value in STEPS]
    (found,) = compare_runs(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL, curve(*lower)))
    assert (found.line, found.first_s) == ("bottom", pytest.approx(2.05, abs=0.06))
    assert found.first_s == found.second_s
    assert re.fullmatch(r"up to 8\.0 kPa lower in the second, for (0\.[89]0|1\.00) s", found.text)
    assert told(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL, curve(*lower)), Tolerances(kpa=8.5)) == []


def test_a_steep_edge_that_is_a_little_later_is_no_difference() -> None:
    later = [(at + 0.08, value) for at, value in STEPS]
    assert told(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL, curve(*later))) == []
    much = [(at + 0.4, value) for at, value in STEPS]
    assert told(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL, curve(*much))) != []


def test_where_one_has_no_value_nothing_is_said_and_a_channel_of_one_is_told() -> None:
    invalid = [(at, None if at > 1.0 else value) for at, value in STEPS]
    assert told(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL, curve(*invalid))) == []
    assert told(tables(NOMINAL, curve(*STEPS)), tables(NOMINAL)) == [
        ("bottom", "only the first recording has this pressure")
    ]


def test_more_than_can_be_aligned_is_refused() -> None:
    many = log(*((float(i), 6, -1 + i % 2, 0) for i in range(2_002)), names=["a_vacuum"])
    with pytest.raises(UsageError, match="Command has 2002 changes; 2000 can be compared"):
        compare_runs(tables(many), tables(many))


def write(folder: Path, states: StatesLog, seed: int) -> Path:
    return written(folder, states, replace(INFO, seed=seed))


def test_the_command_lists_the_differences(tmp_path: Path) -> None:
    one, other = write(tmp_path / "one", NOMINAL, 1), write(tmp_path / "other", FAILS_ONCE, 2)
    done = CliRunner().invoke(eehal, ["compare", str(one), str(other)])
    assert done.exit_code == 1
    assert done.stdout.splitlines() == [
        "Seed: 1, in the second 2",
        " 2.000 s   8.250 s  Cylinder      EXTENDED: 6.25 s later in the second",
        "       -   6.500 s  Cylinder      RETRACTED: only in the second",
        "       -   7.500 s  Cylinder      PENDING EXTEND: only in the second",
        "11.000 s  11.000 s  End effector  RELEASING: 6.25 s earlier in the second",
        "4 differences.",
    ]
    done = CliRunner().invoke(eehal, ["compare", str(one), str(one), "--json"])
    assert (done.exit_code, json.loads(done.stdout)["differences"]) == (0, [])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["{one}", "{here}/nothing"], "Cannot be read: No such file or directory."),
        (["{one}", "{here}/empty"], "This recording holds no row."),
    ],
)
def test_what_cannot_be_compared_is_refused(options: list[str], said: str, tmp_path: Path) -> None:
    one = write(tmp_path / "one", NOMINAL, 1)
    write(tmp_path / "empty", log(), 1)
    words = [each.format(one=one, here=tmp_path) for each in options]
    done = CliRunner().invoke(eehal, ["compare", *words])
    assert isinstance(done.exception, UsageError)
    assert done.exception.what == said


def test_tables_are_read_from_a_folder_or_its_states(tmp_path: Path) -> None:
    one = write(tmp_path / "one", NOMINAL, 1)
    assert read_tables(one).log.rows == read_tables(one / "states.csv").log.rows == NOMINAL.rows
