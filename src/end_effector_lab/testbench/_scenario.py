"""What goes wrong, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

NEVER = 10**9


@dataclass(frozen=True)
class Effect:
    """What is wrong with one device."""

    dead_activations: int = 0
    """So many activations, counted from the choice of the scenario, have no effect."""
    stuck: bool = False
    """Its valve does not close again."""
    leak_l_min: float = 0.0
    """Leak at 60 kPa of vacuum."""
    leak_grows_l_min_s: float = 0.0
    """So much more of it with each second of suction."""
    lost_after_us: int | None = None
    """What is held is lost so long after the activation; the line stays active."""
    invalid: bool = False
    """Its pressure is marked as invalid on the link."""
    shows_kpa: float | None = None
    """Its sensor shows this gauge pressure, whatever is there."""
    frozen_after_us: int | None = None
    """So long after the choice of the scenario its sensor stays at what it shows."""
    swapped: bool = False
    """Its sensor is exchanged with that of the next actuator of the sequence."""
    locked_shows: bool | None = None
    """The tool changer's sensor of "locked" shows this, whatever is there."""
    unlocked_shows: bool | None = None
    """The same of "unlocked"."""
    stand_shows: bool | None = None
    """The same of the tool's stand."""


@dataclass(frozen=True)
class Scenario:
    """What is wrong with a whole bench; made of text by :func:`parse_scenario`."""

    text: str = "nominal"
    effects: Mapping[str, Effect] = field(default_factory=dict)
    silent_after_us: int | None = None
    """The link falls silent so long after the choice of the scenario."""
    babble_after_us: int | None = None
    """So long after the choice of the scenario the link carries nothing but random bytes."""
    reboot_after_us: int | None = None
    """So long after the choice of the scenario the device that sends restarts, once."""
    noise: float = 0.0
    """Share of the bytes on the link that are changed."""
    flips: float = 0.0
    """Share of the bits on the link that are turned over."""
    bursts: float = 0.0
    """Share of the frames on the link of which up to sixteen bytes in a row are changed."""
    dropped: float = 0.0
    """Share of the bytes on the link that are lost."""
    doubled: float = 0.0
    """Share of the bytes on the link that come twice."""
    supply_kpa: float | None = None
    """Regulated supply pressure; ``None``: the description's nominal one."""
    tool_present: bool = True
    in_stand: bool = True
    estop_ok: bool = True

    def effect(self, device: str) -> Effect:
        """What is wrong with a device."""
        return self.effects.get(device, Effect())
