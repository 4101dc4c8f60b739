"""What is shown: records in, JSON out; sans-IO."""

from ._faults import FaultsView
from ._interlocks import RULES
from ._log import EventLog
from ._tool_view import STALE_US, ToolView
