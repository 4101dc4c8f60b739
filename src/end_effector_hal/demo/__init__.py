"""The demo: the paper's scenarios played, recorded, judged and drawn, on real ROS or without it."""

from ._demo import run_demo
from ._finding import LATEST_S, Finding, Measure
from ._judge import judge
from ._report import Report
from ._ros import need_ros
from ._scenario import Expected, Order, Scenario
from ._scenarios import culprit_of, scenarios
from ._table import print_table

__all__ = [
    "LATEST_S",
    "Expected",
    "Finding",
    "Measure",
    "Order",
    "Report",
    "Scenario",
    "culprit_of",
    "judge",
    "need_ros",
    "print_table",
    "run_demo",
    "scenarios",
]
