"""The node DataLogger: writes the run folder."""

from ._data_logger import DataLogger

__all__ = ["DataLogger"]
