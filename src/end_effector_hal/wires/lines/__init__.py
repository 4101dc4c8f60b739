"""Lines: binary outputs. The `gpiod` back-end drives real lines, `virtual` those of a simulated chip in a file."""

from ._backend import LineBackend, LineHandover, RemoteLines
from ._chip_log import ChipLog, Edge
from ._composed import ComposedLines
from ._gpiod import CONSUMER, GpiodLines, find_chips, line_infos, load_gpiod, open_chip
from ._virtual import Pull, VirtualChip, VirtualLines, VirtualPins, read_chip
from ._watcher import ChipWatcher

__all__ = [
    "CONSUMER",
    "ChipLog",
    "ChipWatcher",
    "ComposedLines",
    "Edge",
    "GpiodLines",
    "LineBackend",
    "LineHandover",
    "Pull",
    "RemoteLines",
    "VirtualChip",
    "VirtualLines",
    "VirtualPins",
    "find_chips",
    "line_infos",
    "load_gpiod",
    "open_chip",
    "read_chip",
]
