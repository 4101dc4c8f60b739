"""What is shown: records in, JSON out; sans-IO."""

from ._tool_view import STALE_US, ToolView

__all__ = ["STALE_US", "ToolView"]
