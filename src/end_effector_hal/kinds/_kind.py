"""The base class of all kinds of devices, which contains everything that differs between devices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Generic, TypeVar

from end_effector_hal.signals import ChannelReadings, Kind
from end_effector_hal.vocabulary import TableState

from ._parts import (
    COMPRESSED_AIR,
    ChannelKey,
    Detector,
    HoldWatch,
    JointRule,
    Pair,
    PressureRange,
    Travel,
)
from .conditions import ConditionDetector, shown
from .stanza import Actuator, EvidenceConditions, Hold, Supply

Stanza = TypeVar("Stanza", bound=Actuator)


class DeviceKind(Generic[Stanza]):
    """A kind of device, such as a vacuum, a cylinder or a clamp; every kind is a subclass.

    A kind has no state; its detectors have.

    1. **Stanza.** ``stanza`` inherits `Actuator`; its ``kind`` is ``Literal[name]``, and the keys of its numbers
       contain the unit (``lost_kpa``, ``timeout_s``). ``orders`` and ``joint_rules`` define which values exclude each
       other.
    2. **Outputs.** ``line`` is active while the actuator shall grip (a mono-stable valve). ``opposing`` is the key of
       a stanza that inherits `Output` and has ``gap_s``: it is never active together with ``line`` (IL-08). If that
       stanza has ``duration_s`` and ``until_gone``, a release activates the output, which blows the part off.
    3. **Channels.** ``channels`` are the keys that name channels. At least one of these channels confirms.
    4. **Evidence.** ``detector`` judges ``readings.fresh``: CONFIRMED (the actuator grips), GONE (it is released),
       PARTIAL (neither is proven), UNKNOWN (no fresh, valid reading of a channel that decides). Nothing is confirmed
       without a reading. A kind whose evidence can be written as conditions returns them from ``preset`` and needs no
       detector of its own. A detector lists every attribute that changes in ``MEMORY``, which traces and replay use.
       ``evidence`` in a description takes precedence over both.
    5. **Plausible.** ``plausible`` is the range of its pressure; a reading outside of it is invalid.
    6. **Margin.** ``margin_pa`` is the distance of its pressure from the threshold that matters, positive on the right
       side; ``margin_from`` names that threshold (such as ``lost``).
    7. **Hold.** ``hold_watch`` warns while a part is held. An actuator that holds by a vacuum (``below_ambient``) must
       be vented before an unlock (IL-01); for all others GONE is sufficient.
    8. **States.** ``states`` are its names for the integers of Table II: 0 inactive, 1 pending, 2 active.
    9. **Words.** ``lost`` describes the readings of a lost part, ``empty`` is the phrase for a grip without a part,
       ``not_fitted`` names the functions that are off because a channel is not carried, ``limits`` are the thresholds
       for recordings and figures.
    10. **Travel.** ``travel`` is the joint that the actuator moves, for robot planning and drawing; None where the
        stanza does not define the distance.
    11. **Model.** The constants of the automata come from the keys that every `Actuator` has.
    """

    name: ClassVar[str]
    stanza: ClassVar[type[Actuator]]
    channels: ClassVar[tuple[ChannelKey, ...]]
    states: ClassVar[type[TableState]]
    orders: ClassVar[tuple[Pair, ...]] = ()
    joint_rules: ClassVar[tuple[JointRule, ...]] = ()
    opposing: ClassVar[str] = ""
    samples: ClassVar[str] = ""
    """Key of the number of consecutive samples that confirm; empty: time alone decides."""
    below_ambient: ClassVar[bool] = False
    """Whether the device holds by a vacuum: its pressure is negative, and must be vented before an unlock."""
    margin_from: ClassVar[str] = ""
    """The threshold from which `margin_pa` measures, such as ``lost``; empty: it has no margin."""
    moves: ClassVar[bool] = False
    """Whether the device travels between two end positions, which are published as positions."""

    empty: ClassVar[str] = "has gripped nothing"
    """Phrase for an actuator whose conditions show that it gripped nothing; follows the actuator's name."""

    def preset(self, actuator: Stanza) -> EvidenceConditions | None:
        """Return the conditions that prove an actuator of this kind; None: its own detector decides."""
        return None

    def detector(self, actuator: Stanza, supply: Supply) -> Detector:
        """Return a new detector for an actuator that declares no evidence of its own."""
        if (preset := self.preset(actuator)) is None:
            raise NotImplementedError(f"the kind {self.name} has neither a preset nor a detector")
        return ConditionDetector(preset)

    def plausible(self, actuator: Stanza) -> PressureRange:
        """Return the range of pressures that are possible at ``channel``."""
        return COMPRESSED_AIR

    def margin_pa(self, actuator: Stanza, gauge_pa: float, supply_pa: float) -> float:
        """Return the distance from the threshold that matters, Pa; negative on the wrong side.

        It is NaN where no pressure decides.

        Args:
            actuator: its stanza.
            gauge_pa: its gauge pressure, Pa; negative for a vacuum.
            supply_pa: the gauge pressure of the supply, Pa.
        """
        return float("nan")

    def hold_watch(self, actuator: Stanza, hold: Hold, period_us: int) -> HoldWatch | None:
        """Return a new watch over one actuator while a part is held; None: the evidence is sufficient.

        ``period_us`` is the period of the frames, µs.
        """
        return None

    def lost(self, actuator: Stanza, readings: ChannelReadings, at: int) -> str:
        """Return the readings of a lost actuator and those required, to follow the words ``… was lost:``."""
        if conditions := self.conditions(actuator):
            return shown(conditions.channels, readings, at)
        return "its sensor shows nothing any more"

    def not_fitted(self, actuator: Stanza, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase for each function that is off because a channel of the actuator is not carried."""
        yield from ()

    def limits(self, actuator: Stanza, supply: Supply) -> dict[str, float]:
        """Return the thresholds for a recording, positive kPa by name; figures draw ``confirmed_kpa``."""
        return {}

    def travel(self, actuator: Stanza) -> Travel | None:
        """Return the joint that the actuator moves; None: there is none, or its distance is not defined."""
        return None

    def conditions(self, actuator: Stanza) -> EvidenceConditions | None:
        """Return the conditions that prove an actuator: its own, else its kind's preset; None: neither."""
        return actuator.evidence or self.preset(actuator)

    def can_confirm(self, actuator: Stanza, carried: Mapping[str, Kind]) -> bool:
        """Return whether any of the carried channels could confirm the actuator."""
        if conditions := self.conditions(actuator):
            return conditions.confirmed.can_be_known(carried)
        return any(name in carried for name in self.proofs(actuator))

    def channel_names(self, actuator: Stanza) -> tuple[str, ...]:
        """Return the names of the actuator's channels that prove something, carried or not."""
        if actuator.evidence is not None:
            return actuator.evidence.channels
        named = (getattr(actuator, each.key) for each in self.channels)
        return tuple(name for name in named if name)

    def proofs(self, actuator: Stanza) -> tuple[str, ...]:
        """Return the names of the actuator's channels that can confirm it alone."""
        named = (getattr(actuator, each.key) for each in self.channels if each.confirms)
        return tuple(name for name in named if name)

    def opposing_output(self, actuator: Stanza) -> Any:
        """Return the stanza of the output that is never active together with ``line``; None: none."""
        return getattr(actuator, self.opposing) if self.opposing else None
