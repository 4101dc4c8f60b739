"""The kind of device that is a vacuum generator with its cups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from end_effector_hal.kinds import (
    COMPRESSED_AIR,
    ChannelKey,
    ChannelReadings,
    Detector,
    DeviceKind,
    JointRule,
    PressureRange,
    Quote,
)
from end_effector_hal.kinds.conditions import part_conditions
from end_effector_hal.kinds.stanza import NO_CHANNEL, EvidenceConditions, Hold, Supply, named
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState

from ._detector import VacuumDetector
from ._hold import VacuumWatch
from ._stanza import VacuumActuator


class VacuumState(TableState):
    """States of a vacuum generator with its cups."""

    OFF = 0
    PENDING_ON = 1
    ON = 2


_THRESHOLDS = ("confirmed_kpa", "gone_kpa", "lost_kpa", "secure_kpa")

# Ambient pressure is 101 kPa at most at sea level; a transmitter may be a few kPa off. What is left of a vacuum that
# is no longer "gone" must not pass for compressed air: then exchanged sensors would be believed.
LOWEST_KPA, HIGHEST_KPA = -110.0, 50.0


def _secure(name: str, numbers: Mapping[str, float], quote: Quote) -> tuple[str, str] | None:
    """Check that a grip stops being secure before it is lost, so that there is a warning."""
    hysteresis, secure, lost, confirmed = numbers.values()
    # If secure is not the highest anyhow, that is the fault.
    if not lost < confirmed <= secure or secure - hysteresis > lost:
        return None
    expected = f"secure_kpa - secure_hysteresis_kpa = {secure - hysteresis:.10g} above {quote('lost_kpa')}"
    return "a grip would be lost before it is no longer secure", expected


class Vacuum(DeviceKind[VacuumActuator]):
    """Kind of a vacuum: confirmed if deep enough, held down to ``lost_kpa``, secure from ``secure_kpa``."""

    name = "vacuum"
    stanza = VacuumActuator
    channels = (
        ChannelKey("channel", Kind.PRESSURE, confirms=True, bit_instead=True),
        ChannelKey("part_bit", Kind.BIT, confirms=True),
        ChannelKey("gone_bit", Kind.BIT),
    )
    states = VacuumState
    # A signal rises through gone, lost at once, lost, confirmed, secure; equal where two may be one.
    orders = (
        ("gone_kpa", "<", "lost_at_once_kpa"),
        ("lost_at_once_kpa", "<=", "lost_kpa"),
        ("lost_kpa", "<", "confirmed_kpa"),
        ("confirmed_kpa", "<=", "secure_kpa"),
    )
    joint_rules = (JointRule(("secure_hysteresis_kpa", "secure_kpa", "lost_kpa", "confirmed_kpa"), _secure),)
    opposing = "blow_off"
    samples = "confirmed_samples"
    below_ambient = True

    def preset(self, part: VacuumActuator) -> EvidenceConditions | None:
        """Return the conditions over its switches; None: it has no part switch."""
        return part_conditions(part)

    def detector(self, part: VacuumActuator, supply: Supply) -> Detector:
        """Return a detector that judges the pressure, or the switches if there is a part switch."""
        return VacuumDetector(part) if self.preset(part) is None else super().detector(part, supply)

    def plausible(self, part: VacuumActuator) -> PressureRange:
        """Return the range of its pressure, which is wider with a blow-off: it adds compressed air."""
        high = COMPRESSED_AIR.high if part.blow_off is not None else HIGHEST_KPA
        return PressureRange(LOWEST_KPA, high, "a vacuum circuit")

    def margin_pa(self, part: VacuumActuator, gauge_pa: float, supply_pa: float) -> float:
        """Return the distance beyond the threshold of loss, Pa."""
        return -gauge_pa - part.lost_kpa * 1000

    def hold_watch(self, part: VacuumActuator, hold: Hold, period_us: int) -> VacuumWatch | None:
        """Return a watch for weak grips and leaks; None: only switches prove the part."""
        return None if self.preset(part) and not named(part.channel) else VacuumWatch(part, hold, period_us)

    def lost(self, part: VacuumActuator, readings: ChannelReadings, at: int) -> str:
        """Return the remaining vacuum and the required one."""
        value = readings.get(part.channel, at)
        if value is None or isinstance(value, bool) or self.preset(part):
            return super().lost(part, readings, at)
        return f"{-value / 1000:.1f} kPa below ambient, {part.lost_kpa:g} kPa required"

    def not_fitted(self, part: VacuumActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase for each thing that a switch without a second sensor does not detect."""
        if self.preset(part) is None:
            return
        if part.channel not in carried:
            yield f"channel: {part.channel}: only {part.part_bit} shows a part: a weak grip and a leak are not detected"
        if part.gone_bit not in carried:
            left = "what is left of a vacuum under its threshold is not seen"
            yield f"gone_bit: {part.gone_bit or NO_CHANNEL}: {part.part_bit} off counts as vented: {left}"

    def limits(self, part: VacuumActuator, supply: Supply) -> dict[str, float]:
        """Return the thresholds, kPa below ambient."""
        return {name: getattr(part, name) for name in _THRESHOLDS}
