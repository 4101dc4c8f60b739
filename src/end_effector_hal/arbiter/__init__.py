"""The line arbiter: the one process that owns the output lines, its interlocks, its journal and the last wills."""

from .client import ArbiterClient, PredicateSender
from .rules import Exclusion, LineArbiter, Need, Policy, SecondCoil
from .server import ArbiterServer, serve
