"""The line arbiter: the one process that owns the output lines, its interlocks, its journal and the last wills."""

from .client import ArbiterClient, PredicateSender
from .records import recorded_left_behind
from .rules import DROP_FIRST, Driven, DrivenLine, Exclusion, LineArbiter, Need, Policy, Role, SecondCoil
from .server import ArbiterServer, serve
