"""The node HALMain: the only interface for applications."""

from ._hal_main import HalMainNode
