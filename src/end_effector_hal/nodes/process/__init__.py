"""Parts of a process with nodes, for both generations of ROS: periodic callbacks, a log that never waits, its end."""

from ._paced_log import BURST, PER_S, Allowance, PacedLog, node_log
from ._process_end import ProcessEnd, guarded, leave_within
from ._ros_class import has_ros_class, ros_class
from ._starters import Starters, Ticker
