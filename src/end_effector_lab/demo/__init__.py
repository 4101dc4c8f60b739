"""The demo: plays, records, judges and draws the paper's scenarios, on real ROS or without it."""

from ._demo import fresh_folder, report_on, run_demo
from ._drive import WithoutRos
from ._progress import StatusLine
from ._report import Report, print_table
from ._ros1 import Ros1
from ._ros2 import Ros2
from ._scenario import DemoScenario, scenarios, unplayable
from ._world import World
