"""A tool and its line arbiter: the policy, the process, connections to it, and what it is told of the sensors."""

from ._policy import OUTPUTS, SENSOR_FAULT, arbiter_policy, output_lines, program_lines, wired_lines
from ._predicate_publisher import PredicatePublisher
from ._process import connect_arbiter, run_arbiter
