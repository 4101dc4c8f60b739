"""The ROS 1 face: a module per node; each translates messages to the core and back, and decides nothing."""

from ._run import run, run_line_owner

__all__ = ["run", "run_line_owner"]
