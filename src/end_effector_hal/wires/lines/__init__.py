"""Lines: binary outputs. The `gpiod` back-end drives real ones, `virtual` those of a chip in a file."""

from end_effector_hal.wires.lines._backend import LineBackend
from end_effector_hal.wires.lines._chip_log import ChipState, Edge, LineState
from end_effector_hal.wires.lines._gpiod import GpiodLines
from end_effector_hal.wires.lines._handing_on import HandsOn
from end_effector_hal.wires.lines._virtual import VirtualLines
from end_effector_hal.wires.lines._virtual_chip import VirtualChip, read_chip
from end_effector_hal.wires.lines._watcher import ChipWatcher

__all__ = [
    "ChipState",
    "ChipWatcher",
    "Edge",
    "GpiodLines",
    "HandsOn",
    "LineBackend",
    "LineState",
    "VirtualChip",
    "VirtualLines",
    "read_chip",
]
