"""The demo: the paper's scenarios played, recorded, judged and drawn, on real ROS or without it."""

from ._child import Child
from ._children import Children
from ._demo import fresh_folder, run_demo
from ._finding import LATEST_S, Finding, Measure
from ._judge import judge
from ._pictures import draw
from ._replayed import replayed
from ._report import Report
from ._ros import need_ros
from ._scenario import DemoScenario, Expected, Order
from ._scenarios import culprit_of, scenarios, unplayable
from ._table import print_table
from ._world import EEHAL

__all__ = [
    "EEHAL",
    "LATEST_S",
    "Child",
    "Children",
    "DemoScenario",
    "Expected",
    "Finding",
    "Measure",
    "Order",
    "Report",
    "culprit_of",
    "draw",
    "fresh_folder",
    "judge",
    "need_ros",
    "print_table",
    "replayed",
    "run_demo",
    "scenarios",
    "unplayable",
]
