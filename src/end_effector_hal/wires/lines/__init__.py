"""Lines: binary outputs. The `gpiod` back-end drives real ones, `virtual` those of a chip in a file."""

from ._backend import LineBackend
from ._chip_log import ChipLog, ChipState, Edge, LineState
from ._gpiod import GpiodLines
from ._handover import LineHandover
from ._virtual import VirtualLines
from ._virtual_chip import VirtualChip, read_chip
from ._watcher import ChipWatcher

__all__ = [
    "ChipLog",
    "ChipState",
    "ChipWatcher",
    "Edge",
    "GpiodLines",
    "LineBackend",
    "LineHandover",
    "LineState",
    "VirtualChip",
    "VirtualLines",
    "read_chip",
]
