"""The line arbiter: the one process that owns the output lines, its interlocks, its journal and the last wills."""

from .client import OwnerClient, Teller, Written
from .rules import Exclusion, Keeper, Need, Policy
from .server import LineOwner, serve

__all__ = ["Exclusion", "Keeper", "LineOwner", "Need", "OwnerClient", "Policy", "Teller", "Written", "serve"]
