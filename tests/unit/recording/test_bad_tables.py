"""Tables of a recording that are none: refused with file and line, or read up to a last line that was cut off."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import read_alarms, read_changer, read_pressures, read_states, read_switches
from end_effector_hal.recording._events import COLUMNS, read_events
from tests.support.trace_recordings import NAMES

READ = {
    "states": read_states,
    "pressures": read_pressures,
    "events": lambda path: read_events(path, NAMES),
    "alarms": read_alarms,
    "switches": read_switches,
    "tool_changer": read_changer,
}
STATES = "time_s,end_effector,command,bottom_vacuum,cylinder\n"
PRESSURE = "time_s,bottom_gauge_kpa\n"
EVENTS = f"{','.join(COLUMNS)}\n1,not gone,,,,,,\n"
ALARMS = "time_s,event,id,about,alarm\n"
HEADERS = {
    "states": STATES, "pressures": PRESSURE, "events": EVENTS, "alarms": ALARMS, "switches": "time_s,open_on\n",
    "tool_changer": "time_s,tool_changer\n",
}  # fmt: skip


@pytest.mark.parametrize(
    ("table", "text", "message"),
    [
        ("states", "", ":1: This file is empty"),
        ("states", "hello\n", ":1: The header is 'hello'"),
        ("states", b"\xff\xfe\x00\x01\n", ":1: The header is"),
        ("states", "time_s,end_effector\n", ":1: The header is"),
        ("states", STATES[:-5], ":1: The header is"),
        ("states", "time_s,end_effector,command,a,a\n", ":1: The column 'a' is given twice."),
        ("states", "time_s,end_effector,command,\n", ":1: '' cannot be the name of a column."),
        ("states", STATES + "0,6,-1,0\n", ":2: This row has 4 fields, the header names 5."),
        ("states", STATES + "0,6,-1,0,0\n1,6,-1,x,0\n", ":3: bottom_vacuum is 'x', expected is an integer"),
        ("states", STATES + "0,6,-1,1.0,0\n", ":2: bottom_vacuum is '1.0', expected is an integer"),
        ("states", STATES + "0,7,-1,0,0\n", ":2: end_effector is 7, which Table II does not have. Expected is 0 to 6."),
        ("states", STATES + "0,6,-2,0,0\n", ":2: command is -2, which Table II does not have. Expected is -1 to 5."),
        ("states", STATES + "0,6,-1,0,3\n", ":2: cylinder is 3, which Table II does not have. Expected is 0 to 2."),
        ("states", STATES + "zero,6,-1,0,0\n", ":2: time_s is 'zero', expected is a number."),
        ("states", STATES + "nan,6,-1,0,0\n", ":2: time_s is 'nan', expected is a number."),
        ("states", STATES + "-1,6,-1,0,0\n", ":2: time_s is -1, expected are seconds"),
        ("states", STATES + "2,6,-1,0,0\n\n1.5,1,2,1,0\n", ":4: Time runs backwards: 1.500000 s follows 2.000000 s."),
        ("pressures", "", ":1: This file is empty"),
        ("pressures", "time,bottom\n", ":1: The header is"),
        ("pressures", "time_s,bottom\n0,1\n", ":1: The column 'bottom' has no unit, expected is a"),
        ("pressures", "time_s,a_mm,a_v\n", ":1: The channel 'a' has two columns."),
        ("pressures", PRESSURE + "0,x\n", ":2: bottom is 'x', expected is a number."),
        ("pressures", PRESSURE + "0\n", ":2: This row has 1 fields, the header names 2."),
        ("pressures", PRESSURE + "1,0\n0,0\n", ":3: Time runs backwards"),
        ("events", EVENTS + "x,not gone,,,,,,\n", ":3: time_s is 'x', expected is a number."),
        ("events", EVENTS + "0,not gone,,,,,,\n", ":3: Time runs backwards"),
        ("events", EVENTS + "1,exploded,,,,,,\n",
         ":3: event is 'exploded'. Expected is one of: command accepted, attempt began"),
        ("events", EVENTS + "1,not gone,jaw,,,,,\n",
         ":3: actuator is 'jaw'. Expected is one of: nothing, bottom_vacuum, cylinder"),
        ("events", EVENTS + "1,attempt began,cylinder,21,,,,\n", ":3: attempt is '21'."),
        ("events", EVENTS + "1,attempt began,cylinder,,,,,\n", ":3: attempt is ''. Expected is one of: 1, 2"),
        ("events", EVENTS + "1,timed out,,1,,,,\n", ":3: actuator is ''. Expected is one of: bottom_vacuum"),
        ("events", EVENTS + "1,state changed,,,OFF,LOCKED,,\n",
         ":3: new is 'LOCKED'. Expected is one of: OFF, GRIPPING"),
        ("events", EVENTS + "1,not gone,,,OFF,,,\n", ":3: old is 'OFF'. Expected is one of: nothing."),
        ("events", EVENTS + "1,state changed,,,OFF,GRIPPED,LAZY,\n", ":3: cause is 'LAZY'."),
        ("events", EVENTS + "1,command accepted,,,,,,dance\n", ":3: command is 'dance'."),
        ("events", EVENTS + "1,not gone\n", ":3: This row has 2 fields, the header names 8."),
        ("events", EVENTS.replace("\n", ",more\n", 1), ":1: This is not a table of events."),
        ("alarms", ALARMS + "x,begun,,,y\n", ":2"),
        ("alarms", ALARMS + "1.0,begun,y\n", ":2"),
        ("alarms", ALARMS + "-1,begun,,,y\n", ":2"),
        ("alarms", ALARMS + "1.0,begun,,,y\rz\n", ":2"),
        ("switches", "time_s,open_on\n0,2\n", ":2: open_on is '2', expected is 1, 0 or nothing."),
        ("switches", "time_s,open\n", ":1: This is not a table of switches."),
        ("switches", "time_s\n", ":1: This is not a table of switches."),
        ("switches", "time_s,open_on\n1,0\n0,1\n", ":3: Time runs backwards"),
        ("tool_changer", "time_s,tool_changer\n0,9\n", ":2: tool_changer is 9, expected is 0 to 5."),
        ("tool_changer", "time_s,tool_changer,x\n", ":1: This is not a table of a tool changer."),
        ("tool_changer", "time_s,tool_changer\n1,0\n0,1\n", ":3: Time runs backwards"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_with_file_and_line(tmp_path, table, text, message):
    path = tmp_path / f"{table}.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(UsageError, match=re.escape(f"{table}.csv{message}")):
        READ[table](path)


@pytest.mark.parametrize(
    ("table", "nothing"), [("events", None), ("alarms", ()), ("switches", None), ("tool_changer", ())]
)
def test_a_recording_without_the_file_has_none(tmp_path, table, nothing):
    assert READ[table](tmp_path / f"{table}.csv") == nothing


@pytest.mark.parametrize("table", READ)
@given(data=st.binary(max_size=200), with_header=st.booleans())
def test_arbitrary_bytes_are_read_or_refused(tmp_path_factory, table, data, with_header):
    path = tmp_path_factory.mktemp("bytes") / f"{table}.csv"
    path.write_bytes((HEADERS[table].encode() if with_header else b"") + data)
    try:
        READ[table](path)
    except UsageError as error:
        assert str(error).startswith(f"{path}:")  # noqa: PT017 - either outcome is fine
