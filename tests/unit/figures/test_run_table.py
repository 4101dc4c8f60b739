"""run.csv: everything of a recording in one table of numbers."""

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import AlarmRow, ChangerRow, PressuresLog, StatesLog
from end_effector_hal.vocabulary import ChangerState
from end_effector_lab.figures._run_table import write_run_table
from tests.support.trace_recordings import log


def test_a_row_for_each_change_of_anything_and_what_has_not_changed_is_repeated(tmp_path):
    states = log((0, 6, -1, 0), (2, 1, 2, 1), names=["cup"])
    pressures = PressuresLog(("air",), ((1.0, (600.0,)), (2.0, (None,))))
    changer = [ChangerRow(1.0, ChangerState.LOCKED)]
    alarms = [
        AlarmRow(1.5, "begun", "One, two."),
        AlarmRow(1.5, "begun", "Three."),
        AlarmRow(3.0, "ended", "Three."),
    ]
    path = write_run_table(tmp_path / "run.csv", states, pressures, changer, alarms)
    assert path.read_text() == (
        "time_s,end_effector,command,cup,tool_changer,alarms,air_gauge_kpa\n"
        "0.000000,6,-1,0,0,0,NaN\n"
        "1.000000,6,-1,0,1,0,600.00\n"
        "1.500000,6,-1,0,1,1,600.00\n"
        "1.500000,6,-1,0,1,2,600.00\n"
        "2.000000,1,2,1,1,2,NaN\n"
        "3.000000,1,2,1,1,1,NaN\n"
    )


def test_states_that_were_left_in_the_instant_of_their_entry_have_rows(tmp_path):
    states = log((0, 1, 2, 1), (5, 2, 2, 1), (5, 4, 3, 0), (5.2, 6, -1, 0), names=["cup"])
    path = write_run_table(tmp_path / "run.csv", states, PressuresLog(("air",), ((5.0, (600.0,)),)))
    assert path.read_text().splitlines()[2:4] == ["5.000000,2,2,1,0,600.00", "5.000000,4,3,0,0,600.00"]


def test_what_cannot_be_written_is_said(tmp_path):
    with pytest.raises(UsageError, match="holds no row"):
        write_run_table(tmp_path / "run.csv", StatesLog(("cup",), ()), None)
    with pytest.raises(UsageError, match="Cannot be written: No such file"):
        write_run_table(tmp_path / "none" / "run.csv", log((0, 6, -1, 0), names=["cup"]), None)
