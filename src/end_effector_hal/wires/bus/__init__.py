"""Buses with commanded devices: outputs that are registers, and the relay of the readings to other programs."""

from ._lines import BusLines, BusLink, bus_relay
from ._output import fresh_for_us
from ._outputs import BusOutputs
from ._traffic import BusTraffic
