"""Faults of a link, each with random strength and length, in the words of the testbench."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

VACUUMS = ("bottom_vacuum", "top_vacuum")
ACTUATORS = ("bottom_vacuum", "cylinder", "top_vacuum")
NOMINAL = "nominal"


@dataclass(frozen=True)
class LinkFault:
    """One fault.

    Attributes:
        kind: row of the table.
        scenario: for the testbench.
        seconds: how long it lasts.
        who: the actuator whose sensor it is, if it is one's.
    """

    kind: str
    scenario: str
    seconds: float
    who: str = ""


Make = Callable[[Random], LinkFault]


def _bytes(kind: str, name: str, low: float, high: float) -> Make:
    """Damage of bytes: now and then one frame only."""

    def make(random: Random) -> LinkFault:
        rate = low * (high / low) ** random.random()
        return LinkFault(kind, f"{name}:{rate:.5f}", random.choice((0.02, 0.06, random.uniform(0.1, 2.0))))

    return make


def _whole(kind: str, name: str, low_s: float, high_s: float) -> Make:
    return lambda random: LinkFault(kind, f"{name}:0", low_s * (high_s / low_s) ** random.random())


def _sensor(kind: str, name: str, *, number: Callable[[Random, str], str] = lambda *_: "") -> Make:
    def make(random: Random) -> LinkFault:
        who = random.choice(ACTUATORS)
        return LinkFault(kind, f"{name}:{who}{number(random, who)}", random.uniform(0.05, 3.0), who)

    return make


def _impossible(random: Random, who: str) -> str:
    return f":{random.uniform(60, 790) if who in VACUUMS else random.uniform(-109, -25):.0f}"


KINDS: Mapping[str, Make] = {
    "bit flips": _bytes("bit flips", "flips", 0.0005, 0.2),
    "bursts": _bytes("bursts", "bursts", 0.05, 1.0),
    "changed bytes": _bytes("changed bytes", "noise", 0.002, 0.5),
    "lost bytes": _bytes("lost bytes", "lost-bytes", 0.002, 0.5),
    "doubled bytes": _bytes("doubled bytes", "doubled-bytes", 0.002, 0.5),
    "silence": _whole("silence", "silent-after", 0.02, 8.0),
    "babble": _whole("babble", "babble-after", 0.02, 4.0),
    "reboot": _whole("reboot", "reboot-after", 0.4, 1.0),
    "swapped channels": _sensor("swapped channels", "swapped"),
    "invalid channel": _sensor("invalid channel", "invalid"),
    "impossible value": _sensor("impossible value", "shows", number=_impossible),
    "frozen sensor": _sensor("frozen sensor", "frozen-after", number=lambda *_: ":0"),
}
PLANTS = (
    *(NOMINAL,) * 6,
    "never-confirms:{}",
    "fails-once:{}",
    "lost-after:{}:1.5",
    "stuck-release:{}",
)
"""What the devices do meanwhile: a false confirmation needs something to be false about."""


def plant(random: Random) -> str:
    """What goes wrong behind the sensors."""
    return random.choice(PLANTS).format(random.choice(ACTUATORS))


def together(plant: str, link: str) -> str:
    """Both at once, as one scenario."""
    parts = [part for part in (plant, link) if part != NOMINAL]
    return ",".join(parts) or NOMINAL
