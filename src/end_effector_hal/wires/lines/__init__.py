"""Lines: binary outputs. The `gpiod` back-end drives real lines, `virtual` those of a simulated chip in a file."""

from ._backend import LineBackend, LineHandover, RemoteLines, line_not_found
from ._chip_log import ChipLog, ChipState, Edge, LineState
from ._composed import ComposedLines
from ._gpiod import (
    CONSUMER,
    GpiodLines,
    busy,
    chip_requests,
    find_chips,
    find_lines,
    line_infos,
    load_gpiod,
    open_chip,
)
from ._virtual import Pull, VirtualChip, VirtualLines, VirtualPins, read_chip
from ._watcher import ChipWatcher

__all__ = [
    "CONSUMER",
    "ChipLog",
    "ChipState",
    "ChipWatcher",
    "ComposedLines",
    "Edge",
    "GpiodLines",
    "LineBackend",
    "LineHandover",
    "LineState",
    "Pull",
    "RemoteLines",
    "VirtualChip",
    "VirtualLines",
    "VirtualPins",
    "busy",
    "chip_requests",
    "find_chips",
    "find_lines",
    "line_infos",
    "line_not_found",
    "load_gpiod",
    "open_chip",
    "read_chip",
]
