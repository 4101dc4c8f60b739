"""Buses that are commanded: outputs that are registers, and what the same bus brings, for all who read it."""

from ._lines import BusLines, BusLink, bus_relay
from ._outputs import BusOutputs, fresh_for_us
from ._traffic import BusTraffic
