"""The ROS 1 face: a module per node; each translates messages to the core and back, and decides nothing."""

from ._name_faults import name_faults
from ._run import run, run_line_owner

__all__ = ["name_faults", "run", "run_line_owner"]
