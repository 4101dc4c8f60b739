"""A whole end-effector in one process: its program, its sensors, goals, listeners, readiness, reset."""

from ._end_effector import EndEffector
from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._plain_outputs import PlainOutputs
from ._ready import changer_is_sensed
from ._reset import latch_stop, reset, reset_tool, stop
