"""``python3 -m end_effector_hal.ros1``: run the check of the launch file before it starts anything."""

import sys

from end_effector_hal.nodes.launching import check_launch

sys.exit(check_launch(sys.argv[1:], "roslaunch"))
