"""Align two recordings, and report their differences with line, time and text."""

from ._compare import Tolerances, compare_runs
from ._run_difference import RunDifference, count_differences
from ._run_tables import RunTables
