"""The UPPAAL networks of two lemmas: the registers of an output on a bus, and deaths at any instant.

In the network of the tool an output on a bus is one boolean that is written at once. The lemma of registers proves what
lies between that boolean and the device: the steps of a command, lost, late and double answers, and deaths of the line
arbiter.
"""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.description import Description
from end_effector_hal.kinds.stanza import RegisterOutput
from timed_automata import Network, load_network

BUS_FILE = Path(__file__).with_name("bus_output.xml")


def bus_networks(description: Description) -> dict[str, Network]:
    """Return the network of each output on a bus, by the name of its actuator."""
    return {
        name: load_network(BUS_FILE, output_constants(part.modbus))
        for name, part in description.ordered
        if part.modbus is not None
    }


def output_constants(output: RegisterOutput) -> dict[str, int]:
    """Return the constants of ``bus_output.xml``, which select the steps of an output's commands."""
    order = output.handshake.order if output.handshake else ""
    return {
        "ACTIVATION": int(output.activation is not None),
        "CARRIES": int(output.commands_activate),
        "SHAKE": {"": 0, "before": 1, "after": 2}[order],
        "VERIFY": int(output.verify is not None),
        "RELEASES": int(output.on_link_loss in ("release", "undefined")),
    }


DEATHS_FILE = Path(__file__).with_name("deaths.xml")


def death_network(description: Description) -> Network:
    """Return the network of deaths, with the time that a line of the tool takes to settle (IL-10).

    In the network of the tool a program dies once, between two reactions, and requests what the automata decide. Here
    it requests anything, and it and the line arbiter die at any instant, any number of times. The network assumes:

    - While a program reports a held part, it deactivates nothing, and its last will keeps what is active ([held] of
      the tool).
    - It reports a held part only after the arbiter has replied to the write whose last will keeps it, with no
      deactivation waiting.
    - A new program reads the levels of the lines before it writes any.
    """
    return load_network(DEATHS_FILE, {"SETTLE": arbiter_policy(description).min_switch_us // 1000})
