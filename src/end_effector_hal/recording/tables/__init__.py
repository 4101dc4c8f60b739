"""The CSV tables of a recording: states, events, pressures, switches, alarms and the tool changer."""

from ._alarms import BEGUN, ENDED, AlarmRow, AlarmsWriter, changed_alarms, read_alarms
from ._changer import ChangerRow, ChangerWriter, read_changer
from ._events import EventRow, EventsWriter, event_row, read_events
from ._pressures import KPA, PressuresLog, PressuresWriter, column_of, read_pressures
from ._states import StatesLog, StatesRow, StatesWriter, read_states
from ._switches import ON, SwitchesLog, SwitchesWriter, read_switches
