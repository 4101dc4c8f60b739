"""What a kind of device is: everything that differs between devices, and nothing else."""

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
    """A vacuum, a cylinder, a clamp …: one subclass each; a kind has no state, its detectors have.

    1. **Stanza.** ``stanza`` inherits `Actuator`; its ``kind`` is ``Literal[name]``, its numbers have their unit in
       their key (``lost_kpa``, ``timeout_s``). ``orders`` and ``joint_rules`` say which numbers exclude each other.
    2. **Outputs.** ``line`` is active while the actuator shall grip (a mono-stable valve). ``opposing`` names the key
       of a stanza ``{line, gap_s}``: an output that is never active together with it (IL-08). With ``duration_s``
       and ``until_gone`` a release drives it: that blows the part off.
    3. **Channels.** ``channels`` are the keys that name channels. At least one of them confirms.
    4. **Evidence.** ``detector`` judges readings: CONFIRMED (it grips), GONE (it is released), PARTIAL (neither is
       proven), UNKNOWN (there is no fresh, valid reading of what decides it). Nothing is confirmed without a reading.
       A kind whose evidence can be said in conditions gives them with ``preset`` and needs no detector of its own.
       What a description declares as ``evidence`` comes before either.
    5. **Plausible.** ``plausible`` is what a pressure of it can be; beyond that the reading is invalid.
    6. **Margin.** ``margin_pa`` is how far its pressure is on the right side of the threshold that matters.
    7. **Hold.** ``hold_watch`` warns while a part is held. What holds by a vacuum (``below_ambient``) must be vented
       before an unlock (IL-01); of the others GONE is enough.
    8. **States.** ``states`` are its words for the integers of Table II: 0 inactive, 1 pending, 2 active.
    9. **Words.** ``lost`` says what its sensor shows when a part is lost, ``empty`` that it has gripped nothing,
       ``not_fitted`` what is off where a channel is not carried, ``limits`` what a recording and its figures show.
    10. **Travel.** ``travel`` is the joint that it moves, for those who plan and draw a robot; None where the stanza
        does not say how far.
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
    """Key of how many consecutive samples confirm; empty: time alone decides."""
    below_ambient: ClassVar[bool] = False
    """Whether it holds by a vacuum: its pressure is negative, is drawn with the vacuums, and must be vented."""
    moves: ClassVar[bool] = False
    """Whether it travels between two end positions, which are published as such."""

    empty: ClassVar[str] = "has gripped nothing"
    """What an actuator has done whose conditions say that it is empty; after its name."""

    def preset(self, part: Stanza) -> EvidenceConditions | None:
        """The conditions that prove an actuator of this kind; None: its detector decides otherwise."""
        return None

    def detector(self, part: Stanza, supply: Supply) -> Detector:
        """A new detector of one actuator, which declares no evidence of its own."""
        if (preset := self.preset(part)) is None:
            raise NotImplementedError(f"the kind {self.name} has neither a preset nor a detector")
        return ConditionDetector(preset)

    def plausible(self, part: Stanza) -> PressureRange:
        """What the pressure at ``channel`` can be."""
        return COMPRESSED_AIR

    def margin_pa(self, part: Stanza, gauge_pa: float, supply_pa: float) -> float:
        """Pa beyond the threshold that matters, negative on its wrong side; NaN where no pressure decides.

        Args:
            part: the actuator.
            gauge_pa: its pressure, vacuum negative.
            supply_pa: that of the supply, gauge.
        """
        return float("nan")

    def hold_watch(self, part: Stanza, hold: Hold, period_us: int) -> HoldWatch | None:
        """A new watch over one actuator while a part is held, for frames of this period; None: evidence is enough."""
        return None

    def lost(self, part: Stanza, readings: ChannelReadings, at: int) -> str:
        """What the sensors show of an actuator that was lost, and what they would have to; after ``… was lost:``."""
        if conditions := self.conditions(part):
            return shown(conditions.channels, readings, at)
        return "its sensor shows nothing any more"

    def not_fitted(self, part: Stanza, carried: Mapping[str, Kind]) -> Iterator[str]:
        """A phrase for each thing that is off because a channel of ``part`` is not carried."""
        yield from ()

    def limits(self, part: Stanza, supply: Supply) -> dict[str, float]:
        """Thresholds for a recording, positive kPa by name; ``confirmed_kpa`` is the one that figures draw."""
        return {}

    def travel(self, part: Stanza) -> Travel | None:
        """The joint that it moves; None: it moves none, or nobody has said how far."""
        return None

    def conditions(self, part: Stanza) -> EvidenceConditions | None:
        """What proves an actuator, as far as conditions say it: its own, or those of its kind."""
        return part.evidence or self.preset(part)

    def can_confirm(self, part: Stanza, carried: Mapping[str, Kind]) -> bool:
        """Whether anything that is carried could confirm it."""
        if conditions := self.conditions(part):
            return conditions.confirmed.can_be_known(carried)
        return any(name in carried for name in self.proofs(part))

    def channel_names(self, part: Stanza) -> tuple[str, ...]:
        """The channels of one actuator that prove something, carried or not."""
        if part.evidence is not None:
            return part.evidence.channels
        named = (getattr(part, each.key) for each in self.channels)
        return tuple(name for name in named if name)

    def proofs(self, part: Stanza) -> tuple[str, ...]:
        """Those of them that alone can confirm it."""
        named = (getattr(part, each.key) for each in self.channels if each.confirms)
        return tuple(name for name in named if name)

    def opposing_output(self, part: Stanza) -> Any:
        """The stanza of the output that is never active together with ``line``; None: there is none."""
        return getattr(part, self.opposing) if self.opposing else None
