"""The parts of a kind: its evidence, the watch over a held part, and the ranges and rules of its numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, runtime_checkable

from end_effector_hal.signals import ChannelReadings, Kind
from end_effector_hal.vocabulary import Evidence


class ChannelKey(NamedTuple):
    """A key of a stanza that names a channel.

    Attributes:
        key: the key in the stanza; its value is the name of a channel, or ``none``: there is no such sensor.
        carries: a pressure or a bit. The key of a bit ends in ``_bit``; the part before it is the meaning of the bit.
        confirms: whether this channel alone can prove that the actuator is active.
        bit_instead: whether a bit may replace this pressure and mean "present", as a vacuum switch does.
    """

    key: str
    carries: Kind
    confirms: bool = False
    bit_instead: bool = False

    @property
    def meaning(self) -> str:
        """Meaning of a bit, such as ``extended`` for the key ``extended_bit``."""
        return self.key.removesuffix("_bit")


class Detector(Protocol):
    """Judges the evidence of one actuator; `end_effector_hal.signals.memory_of` describes its ``MEMORY``."""

    MEMORY: ClassVar[dict[str, Any]]

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence of ``readings.fresh``, the values at ``at`` µs.

        It is called after a frame, or after readings became stale by time alone.
        """
        ...


class HoldFinding(NamedTuple):
    """An alarm about a held part that begins, continues or has ended.

    Attributes:
        id: `end_effector_hal.vocabulary.WEAK` or ``LEAK``.
        values: the values for its text in the table of alarms; ``text`` alone: a complete sentence.
        over: whether it has ended.
    """

    id: str
    values: Mapping[str, str | int | float]
    over: bool = False


class HoldWatch(Protocol):
    """Watches one actuator while a part is held."""

    MEMORY: ClassVar[dict[str, Any]]
    secure: bool
    """Whether the grip is secure, which is more than confirmed."""

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Process the newest readings, at ``at`` µs."""
        ...

    def findings(self, since: int, at: int) -> Iterable[HoldFinding]:
        """Return the findings about the actuator, which is confirmed and has been held since ``since`` µs."""
        ...

    def dropped(self) -> None:
        """Handle a Drop: nothing is held any more."""
        ...


@runtime_checkable
class LeakWatch(HoldWatch, Protocol):
    """A watch that also follows a pressure."""

    @property
    def leak_kpa_s(self) -> float | None:
        """Fall of the vacuum, kPa/s; 0: it does not fall; None: not known."""

    @property
    def lost_in_s(self) -> float | None:
        """Time until the part would be lost, s; None: never, if the present trend goes on."""


@dataclass(frozen=True, slots=True)
class PressureRange:
    """A range of gauge pressures, kPa; ``what`` names the measured circuit in a sentence."""

    low: float
    high: float
    what: str

    def has(self, pascal: int) -> bool:
        """Return whether the circuit can have this pressure."""
        lowest, highest = self.limits_pa
        return lowest <= pascal <= highest

    @property
    def limits_pa(self) -> tuple[float, float]:
        """The lowest and the highest pressure that the circuit can have, Pa."""
        return self.low * 1000, self.high * 1000

    def fault(self, channel: str, pascal: int) -> str:
        """Return a sentence that explains why a value of the channel is invalid."""
        limits = f"{self.low:g} to {self.high:g} kPa"
        return (
            f"The channel {channel} shows {pascal / 1000:.0f} kPa, which {self.what} cannot have ({limits}): "
            "it counts as invalid. Is its sensor broken, or exchanged with another?"
        )


def below_ambient_kpa(value: int | bool) -> float:
    """Return the vacuum that a reading shows, kPa below ambient; a switch counts as 100 kPa if on, else 0."""
    if isinstance(value, bool):
        return 100.0 if value else 0.0
    return -value / 1000


class Travel(NamedTuple):
    """The joint that an actuator moves: from 0, where it is released, to ``upper``, where it is confirmed.

    Attributes:
        joint: type of the joint in a URDF.
        upper: m, or rad for a revolute joint; more than 0.
    """

    joint: Literal["prismatic", "revolute"]
    upper: float


COMPRESSED_AIR = PressureRange(-10.0, 2000.0, "compressed air")
"""Range of compressed air; slightly below 0 because a transmitter may be a few kPa off."""


Pair = tuple[str, str, str]
"""An order of two keys, such as ``("gone_kpa", "<", "lost_kpa")``; the relation is ``<`` or ``<=``."""

Quote = Callable[[str], str]
"""Formats a key with its value, such as ``gone_kpa = 10 (default)``."""


class JointRule(NamedTuple):
    """A rule for several numbers that only make sense together.

    Attributes:
        keys: keys of the stanza, or of the supply's stanza (``supply.refuse_kpa``).
        fault: receives the name of the actuator, the number of each key, and a `Quote`; returns the fault and the
            expected value, or None.
    """

    keys: tuple[str, ...]
    fault: Callable[[str, Mapping[str, float], Quote], tuple[str, str] | None]
