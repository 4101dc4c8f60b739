"""``python3 -m end_effector_hal.ros2 hal --ros-args -p profile:=NAME``: the executables, without a workspace."""

import sys

from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.process import guarded

from ._run import PROGRAMS, run


def _unknown() -> int:
    what = f"{sys.argv[1]!r} is no program." if sys.argv[1:] else "No program is named."
    raise UsageError(what, todo=f"There are {', '.join(PROGRAMS)}.")


sys.exit(
    run(sys.argv[1], sys.argv[1:]) if sys.argv[1:2] and sys.argv[1] in PROGRAMS else guarded("ros2", _unknown)
)
