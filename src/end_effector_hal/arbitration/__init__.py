"""A tool at the line arbiter: its policy, the process that enforces it, connections to it, what its sensors prove."""

from ._policy import OUTPUTS, SENSOR_FAULT, arbiter_policy, output_lines, program_lines, wired_lines
from ._predicate_publisher import PredicatePublisher
from ._process import connect_arbiter, run_arbiter
