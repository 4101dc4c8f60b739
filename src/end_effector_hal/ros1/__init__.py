"""The ROS 1 face: a module per node; each translates messages to the core and back, and decides nothing."""

from ._master import _Transport, ask_pid, master_uri
from ._name_faults import name_faults
from ._run import run, run_line_owner
from ._table import HAL_NODES

__all__ = ["HAL_NODES", "_Transport", "ask_pid", "master_uri", "name_faults", "run", "run_line_owner"]
