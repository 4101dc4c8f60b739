"""Inputs of the board: digital ones through libgpiod or on a virtual chip, analog ones through Linux IIO."""

from ._analog import AnalogReader, find_device
from ._gpiod import INPUT_CONSUMER
from ._lines import input_lines, pulls_of
from ._reader import InputsHealth, InputsReader, lines_of
from ._relayed import inputs_record
