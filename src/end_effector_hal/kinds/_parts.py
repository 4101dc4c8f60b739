"""What a kind is made of: evidence, the watch over a held part, ranges and rules of its numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, runtime_checkable

from end_effector_hal.signals import ChannelReadings, Kind
from end_effector_hal.vocabulary import Evidence


class ChannelKey(NamedTuple):
    """A key of a stanza that names a channel.

    Attributes:
        key: in the stanza; its value is the name of a channel, or ``none``: there is no such sensor.
        carries: a pressure or a bit. A key of a bit ends in ``_bit``; what stands before it is what the bit means.
        confirms: whether this channel alone can prove the actuator to be active.
        bit_instead: a bit in the place of this pressure says "present", as the switch of a vacuum does.
    """

    key: str
    carries: Kind
    confirms: bool = False
    bit_instead: bool = False

    @property
    def meaning(self) -> str:
        """What a bit says, such as ``extended`` of ``extended_bit``."""
        return self.key.removesuffix("_bit")


class Detector(Protocol):
    """The evidence of one actuator; its ``MEMORY`` is that of `end_effector_hal.signals.memory_of`."""

    MEMORY: ClassVar[dict[str, Any]]

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """The evidence at ``at`` µs: after a frame, and also when time alone has made readings stale."""
        ...


class HoldFinding(NamedTuple):
    """An alarm about a held part that begins or stands; ``over``: it has ended.

    Attributes:
        id: `end_effector_hal.vocabulary.WEAK` or ``LEAK``.
        values: of its text in the table of alarms; ``text`` alone: a sentence of its own.
        over: it has ended.
    """

    id: str
    values: Mapping[str, str | int | float]
    over: bool = False


class HoldWatch(Protocol):
    """The watch over one actuator while a part is held."""

    MEMORY: ClassVar[dict[str, Any]]
    secure: bool
    """Whether the grip is more than confirmed."""

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Look at the newest readings, at ``at`` µs."""
        ...

    def findings(self, since: int, at: int) -> Iterator[HoldFinding]:
        """The findings about the actuator, which is held since ``since`` µs and confirmed."""
        ...

    def dropped(self) -> None:
        """Nothing is held any more."""
        ...


@runtime_checkable
class LeakWatch(HoldWatch, Protocol):
    """One that follows a pressure as well."""

    @property
    def leak_kpa_s(self) -> float | None:
        """By how much it falls in a second; 0: it does not. None: not known."""

    @property
    def lost_in_s(self) -> float | None:
        """Until the part would be lost; None: never, as it goes now."""


@dataclass(frozen=True, slots=True)
class PressureRange:
    """Gauge kPa from ``low`` to ``high``; ``what`` is measured, for a sentence."""

    low: float
    high: float
    what: str

    def has(self, pascal: int) -> bool:
        """Whether the circuit can have this pressure."""
        return self.low * 1000 <= pascal <= self.high * 1000

    def fault(self, channel: str, pascal: int) -> str:
        """Why a value is none."""
        limits = f"{self.low:g} to {self.high:g} kPa"
        return (
            f"The channel {channel} shows {pascal / 1000:.0f} kPa, which {self.what} cannot have ({limits}): "
            "it counts as invalid. Is its sensor broken, or exchanged with another?"
        )


def below_ambient_kpa(value: int | bool) -> float:
    """The vacuum that a reading shows; a switch shows all or nothing."""
    if isinstance(value, bool):
        return 100.0 if value else 0.0
    return -value / 1000


class Travel(NamedTuple):
    """How an actuator moves a joint: from 0, where it is released, to ``upper``, where it is confirmed.

    Attributes:
        joint: its type in a URDF.
        upper: m, or rad of one that turns; more than 0.
    """

    joint: Literal["prismatic", "revolute"]
    upper: float


COMPRESSED_AIR = PressureRange(-10.0, 2000.0, "compressed air")
"""A transmitter may be a few kPa off."""


Pair = tuple[str, str, str]
"""``("gone_kpa", "<", "lost_kpa")``: two keys, and ``<`` or ``<=``."""

Quote = Callable[[str], str]
"""From a key to ``gone_kpa = 10 (default)``."""


class JointRule(NamedTuple):
    """Several numbers that only make sense together.

    Attributes:
        keys: of the stanza, or ``supply.refuse_kpa``: of that of the supply.
        fault: takes the name of the actuator, the number of each key, and a `Quote`; returns what is wrong and
            what is expected, or None.
    """

    keys: tuple[str, ...]
    fault: Callable[[str, Mapping[str, float], Quote], tuple[str, str] | None]
