"""The lemma of registers: its network for each output on a bus.

The network of the tool has such an output as one boolean that is written at once. What stands between that boolean and
the device, the steps of a command, lost, late and double answers, and the deaths of the line arbiter, is proven here.
"""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.kinds.stanza import RegisterOutput
from timed_automata import Network, load_network

BUS_FILE = Path(__file__).with_name("bus_output.xml")


def bus_networks(description: Description) -> dict[str, Network]:
    """The network of each output on a bus, by the name of its actuator."""
    return {
        name: load_network(BUS_FILE, output_constants(part.modbus))
        for name, part in description.ordered
        if part.modbus is not None
    }


def output_constants(output: RegisterOutput) -> dict[str, int]:
    """Constants of ``bus_output.xml``: which steps the commands of an output have."""
    order = output.handshake.order if output.handshake else ""
    return {
        "ACTIVATION": int(output.activation is not None),
        "CARRIES": int(output.commands_activate),
        "SHAKE": {"": 0, "before": 1, "after": 2}[order],
        "VERIFY": int(output.verify is not None),
        "RELEASES": int(output.on_link_loss in ("release", "undefined")),
    }
