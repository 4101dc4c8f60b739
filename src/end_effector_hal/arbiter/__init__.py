"""The line arbiter: the one process that owns the output lines, its interlocks, its journal and the last wills."""

from ._client import OwnerClient, Written
from ._keeper import Keeper
from ._policy import Exclusion, Need, Policy
from ._serve import serve
from ._server import LineOwner
from ._teller import Teller

__all__ = ["Exclusion", "Keeper", "LineOwner", "Need", "OwnerClient", "Policy", "Teller", "Written", "serve"]
