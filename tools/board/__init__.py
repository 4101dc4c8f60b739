"""The emulated Verdin: runs the HAL on the board's own device tree, GPIO controller and UART, without a board."""

from ._errors import BoardError
from ._machine import Ended, run_board
from ._parts import board_parts
from ._pins import pins_of
from ._play import need_its_wires, play_on_board
from ._progress import BoardProgress
from ._qemu import QemuInputs
