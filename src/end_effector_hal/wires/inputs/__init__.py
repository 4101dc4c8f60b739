"""Inputs of the board: digital ones through libgpiod or on a virtual chip, analog ones through Linux IIO."""

from ._analog import AnalogReader, find_device
from ._gpiod import INPUT_CONSUMER, GpiodInputLines
from ._lines import Edges, InputLines, LineEdge, input_lines, pulls_of
from ._reader import InputsHealth, InputsReader
from ._virtual import VirtualInputLines

__all__ = [
    "INPUT_CONSUMER",
    "AnalogReader",
    "Edges",
    "GpiodInputLines",
    "InputLines",
    "InputsHealth",
    "InputsReader",
    "LineEdge",
    "VirtualInputLines",
    "find_device",
    "input_lines",
    "pulls_of",
]
