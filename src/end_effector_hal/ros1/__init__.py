"""The nodes in ROS 1: how they start, talk and end there."""

from ._run import run, run_line_owner

__all__ = ["run", "run_line_owner"]
