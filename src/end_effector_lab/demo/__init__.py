"""The demo: plays, records, judges and draws the paper's scenarios, on real ROS or without it."""

from ._demo import fresh_folder, report_on, run_demo
from ._progress import StatusLine
from ._report import Report, print_table
from ._ros import Ros1, Ros2
from ._scenario import DemoScenario, scenarios, unplayable
from ._world import WithoutRos, World
