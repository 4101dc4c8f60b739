"""Lines: binary outputs. The `gpiod` back-end drives real lines, `virtual` those of a simulated chip in a file."""

from ._backend import LineBackend, LineHandover, RemoteLines
from ._chip_log import ChipLog, Edge
from ._chips import (
    UNIQUE,
    LinePlace,
    SeenChip,
    ambiguous,
    chip_requests,
    find_chips,
    find_lines,
    missing_line,
    open_chip,
    places_of,
    see_chip,
    shared_lines,
)
from ._composed import ComposedLines
from ._gpiod import CONSUMER, GpiodLines, load_gpiod
from ._virtual import Pull, VirtualChip, VirtualLines, VirtualPins, read_chip
from ._watcher import ChipWatcher
