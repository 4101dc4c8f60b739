"""The line arbiter: the one process that owns the output lines, their interlocks, its journal and the last wills."""

from ._predicate_publisher import REPEAT_US, PredicatePublisher
from ._process import connect_arbiter, run_arbiter
from ._tool_policy import HAL, OUTPUTS, SENSOR_FAULT, arbiter_policy, client_lines, output_lines, wired_lines
from .client import ArbiterClient, PredicateSender
from .records import recorded_left_behind
from .rules import DROP_FIRST, Driven, DrivenLine, Exclusion, LineArbiter, Need, Policy, Role, SecondCoil
from .server import ArbiterServer, serve
