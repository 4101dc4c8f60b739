"""Buses that are commanded: outputs that are registers, and what the same bus brings, for all who read it."""

from ._lines import BusLines, BusLink
from ._outputs import BusOutputs
from ._relay import RelayServer, connect_relay, relay_path
from ._traffic import BusTraffic

__all__ = [
    "BusLines",
    "BusLink",
    "BusOutputs",
    "BusTraffic",
    "RelayServer",
    "connect_relay",
    "relay_path",
]
