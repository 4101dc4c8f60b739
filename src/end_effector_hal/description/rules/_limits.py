"""Rules for the size of a tool: what does not fit into a message between its programs."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description._fault import Fault
from end_effector_hal.description._shape import Facts
from end_effector_hal.vocabulary import MOST_ACTUATORS, MOST_CHANNELS

MOST = {"actuators": MOST_ACTUATORS, "outputs": MOST_ACTUATORS, "channels": MOST_CHANNELS}


def limit_faults(facts: Facts) -> Iterator[Fault]:
    """Stanzas with more names than a tool may have."""
    for stanza, most in MOST.items():
        names = facts.names(stanza) if isinstance(facts.get(stanza), dict) else []
        if len(names) > most:
            place, what = facts.places.key(stanza), f"too many {stanza}"
            yield Fault.at(place, "EE-208", what, found=str(len(names)), expected=f"at most {most}")
