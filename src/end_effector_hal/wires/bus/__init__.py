"""Buses that are commanded: outputs that are registers, and what the same bus brings, for all who read it."""

from ._lines import BusLines, BusLink, bus_relay
from ._output import fresh_for_us
from ._outputs import BusOutputs
from ._traffic import BusTraffic
