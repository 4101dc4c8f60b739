"""The page's server: access rules, control by one page, and the data sent to browsers."""

from ._address import PageAddress
from ._control import ControlLease
from ._faults import FaultCommands
from ._guard import Asked, Guard
from ._serve import serve_page, serve_recordings
