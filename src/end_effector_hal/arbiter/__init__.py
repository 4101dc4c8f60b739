"""The line arbiter: the one process that owns the output lines, their interlocks, its journal and the last wills."""

from ._predicate_publisher import PredicatePublisher
from ._process import connect_arbiter, run_arbiter
from ._tool_policy import HAL, OUTPUTS, SENSOR_FAULT, arbiter_policy, client_lines
from .client._client import ArbiterClient
from .client._sender import PredicateSender
from .records._records import recorded_left_behind
from .rules._arbiter import LineArbiter
from .rules._lines import DROP_FIRST
from .rules._policy import Policy
from .server._server import ArbiterServer
