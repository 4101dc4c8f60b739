"""A tool and its commands: a `Tool` is an `EndEffector` in this process, or a `RemoteTool` in another one."""

from ._end_effector import EndEffector
from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._ready import changer_is_sensed, silent_links
from ._remote_tool import RemoteTool
from ._reset import latch_stop, reset, stop
from ._tool import Tool
