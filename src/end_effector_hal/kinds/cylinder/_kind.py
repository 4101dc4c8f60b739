"""The kind of device that is a pneumatic cylinder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from end_effector_hal.kinds import ChannelKey, ChannelReadings, DeviceKind, JointRule, Quote, Travel
from end_effector_hal.kinds.stanza import NO_CHANNEL, Supply
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState

from ._detector import CylinderDetector
from ._stanza import CylinderActuator


class CylinderState(TableState):
    """States of a pneumatic cylinder."""

    RETRACTED = 0
    PENDING_EXTEND = 1
    EXTENDED = 2


def _apart(name: str, numbers: Mapping[str, float], quote: Quote) -> tuple[str, str] | None:
    """Check that the extended threshold is above the retracted one even at the lowest allowed supply."""
    retracted, fraction, refuse = numbers.values()
    if retracted < fraction * refuse:
        return None
    product = f"extended_fraction * supply.refuse_kpa = {fraction * refuse:.10g}"
    return f"{name!r} would be extended and retracted at once", f"{quote('retracted_kpa')} below {product}"


class Cylinder(DeviceKind[CylinderActuator]):
    """Kind of a cylinder: confirmed when extended, by a share of the supply pressure or a position bit."""

    name = "cylinder"
    stanza = CylinderActuator
    channels = (
        ChannelKey("channel", Kind.PRESSURE, confirms=True),
        ChannelKey("extended_bit", Kind.BIT, confirms=True),
        ChannelKey("retracted_bit", Kind.BIT),
    )
    states = CylinderState
    # What takes longer than its time-out can never happen.
    orders = (("extended_s", "<", "timeout_s"), ("retracted_s", "<", "release_s"))
    joint_rules = (JointRule(("retracted_kpa", "extended_fraction", "supply.refuse_kpa"), _apart),)
    moves = True

    def detector(self, part: CylinderActuator, supply: Supply) -> CylinderDetector:
        """Return a detector that judges the pressure and the position bits."""
        return CylinderDetector(part, supply)

    def margin_pa(self, part: CylinderActuator, gauge_pa: float, supply_pa: float) -> float:
        """Return the distance above the threshold of confirmation, Pa."""
        return gauge_pa - part.extended_fraction * supply_pa

    def lost(self, part: CylinderActuator, readings: ChannelReadings, at: int) -> str:
        """Return the remaining pressure and the required one."""
        value = readings.get(part.channel, at)
        if value is None or isinstance(value, bool):
            return super().lost(part, readings, at)
        return f"{value / 1000:.0f} kPa, {part.extended_fraction:.0%} of the supply pressure required"

    def not_fitted(self, part: CylinderActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield for each missing sensor which other one proves the position, and what is not detected."""
        if part.channel not in carried:
            proof = f"only {part.extended_bit} confirms that it is extended, thresholds are off"
            yield f"channel: {part.channel}: {proof}: lost air is not detected"
        for key, bit in (("extended_bit", part.extended_bit), ("retracted_bit", part.retracted_bit)):
            if bit not in carried:
                yield f"{key}: {bit or NO_CHANNEL}: {self._instead(part, key.removesuffix('_bit'), carried)}"

    def limits(self, part: CylinderActuator, supply: Supply) -> dict[str, float]:
        """Return the thresholds at the nominal supply pressure, kPa."""
        extended_kpa = part.extended_fraction * supply.nominal_kpa
        lost_kpa = extended_kpa - supply.hysteresis_kpa
        return {"confirmed_kpa": extended_kpa, "gone_kpa": part.retracted_kpa, "lost_kpa": lost_kpa}

    def travel(self, part: CylinderActuator) -> Travel | None:
        """Return the stroke as a prismatic joint; None: the stanza does not define it."""
        return None if part.stroke_mm is None else Travel("prismatic", part.stroke_mm / 1000)

    def _instead(self, part: CylinderActuator, position: str, carried: Mapping[str, Kind]) -> str:
        if part.channel in carried:
            return f"only the pressure {part.channel} confirms that it is {position}: a stuck rod is not detected"
        if position == "extended":
            return "extended cannot be proven"
        return "retracted is assumed to be the opposite of extended: a rod that stops on its way counts as retracted"
