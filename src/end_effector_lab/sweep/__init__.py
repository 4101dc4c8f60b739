"""A grid over values of a description: which combinations hold, what fails first, the worst cases."""

from ._axis import Axis, combinations, read_axis
from ._report import table
from ._sweep import DOCUMENT, TABLE, Proven, sweep, sweep_folder
