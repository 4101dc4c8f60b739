"""The page's server: who may see it, who commands, what goes out."""

from ._address import PageAddress
from ._control import ControlLease
from ._faults import FaultCommands
from ._guard import Asked, Guard
from ._serve import serve_page, serve_recordings
