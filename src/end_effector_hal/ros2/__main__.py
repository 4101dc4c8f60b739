"""``python3 -m end_effector_hal.ros2 hal --ros-args -p profile:=NAME``: run the executables without a workspace."""

import sys

from ._run import main

sys.exit(main(sys.argv[1:]))
