"""The network of deaths: the lines of a held part, whichever process dies, whenever and how often.

In the network of the tool a program dies once, between two reactions, and asks for what the automata decide. Here it
asks for anything, and it and the line arbiter die at any instant. What this network assumes of a program:

- While it tells that it holds, it deactivates nothing, and its last will keeps what is active ([held] of the tool).
- It tells so only after the arbiter has replied to the write whose last will keeps it, with nothing waiting that it has
  asked to be deactivated.
- A new program finds the lines as they are, before it writes any.
"""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.arbitration import arbiter_policy
from end_effector_hal.description import Description
from timed_automata import Network, load_network

DEATHS_FILE = Path(__file__).with_name("deaths.xml")


def death_network(description: Description) -> Network:
    """The network, with the time that a line of a tool takes to settle (IL-10)."""
    return load_network(DEATHS_FILE, {"SETTLE": arbiter_policy(description).min_switch_us // 1000})
