"""The node HALMain: the only interface of applications."""

from ._hal_main import HalMainNode
