"""Lines: binary outputs. The `gpiod` back-end drives real ones, `virtual` those of a chip in a file."""

from ._backend import LineBackend, LineHandover
from ._chip_log import ChipLog, ChipState, Edge, LineState
from ._gpiod import CONSUMER, GpiodLines, find_chips, line_infos, load_gpiod, open_chip
from ._virtual import VirtualChip, VirtualLines, read_chip
from ._watcher import ChipWatcher

__all__ = [
    "CONSUMER",
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
    "find_chips",
    "line_infos",
    "load_gpiod",
    "open_chip",
    "read_chip",
]
