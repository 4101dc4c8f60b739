"""The kind ``magnet``: a magnet that holds while its line is active, and a sensor of the part."""

from ._kind import Magnet
