"""The node DataLogger: writes the run folder."""

from ._commands_log import CommandsLog
from ._data_logger import DataLogger
from ._rows import events_of, write_state
