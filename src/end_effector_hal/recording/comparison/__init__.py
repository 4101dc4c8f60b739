"""What two recordings have in common is aligned, and what is left is told: line, time and what."""

from ._compare import Tolerances, compare_runs
from ._run_difference import RunDifference, count_differences
from ._run_tables import RunTables
