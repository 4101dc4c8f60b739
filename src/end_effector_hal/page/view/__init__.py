"""The view model of the page: it converts records to JSON and does no I/O."""

from ._cards import Cards, margin_kpa
from ._curves import Curve
from ._faults import FaultsView
from ._log import EventLog
from ._timeline import FRESH_US
from ._tool_view import ToolView
