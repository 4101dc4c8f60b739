"""The device kind ``cylinder``, driven by air: its keys, and its evidence from pressure and position bits.

The defaults are those of the paper's tool.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from end_effector_hal.kinds import ChannelKey, ChannelReadings, DeviceKind, JointRule, Quote, Travel
from end_effector_hal.kinds.stanza import (
    NO_CHANNEL,
    Actuator,
    Kilopascal,
    MaybeMillimetres,
    Name,
    Seconds,
    Supply,
)
from end_effector_hal.signals import NESTED, Kind, Streak
from end_effector_hal.vocabulary import Evidence, TableState, to_us


class CylinderActuator(Actuator):
    """A pneumatic cylinder, single-acting with spring return or driven by a mono-stable valve."""

    kind: Literal["cylinder"] = Field(description="what it is")
    extended_fraction: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.85, description="at least this share of the supply pressure: extended"
    )
    extended_s: Seconds = Field(default=0.1, description="for at least this long")
    retracted_kpa: Kilopascal = Field(default=50.0, description="less than this: retracted")
    retracted_s: Seconds = Field(default=0.2, description="for at least this long")
    extended_bit: Name | None = Field(
        default="cylinder_extended", description="position bit that proves extended; none: no such sensor"
    )
    retracted_bit: Name | None = Field(
        default="cylinder_retracted", description="position bit that proves retracted; none: no such sensor"
    )
    stroke_mm: MaybeMillimetres = Field(
        default=None, description="from retracted to extended, for joint_states and the URDF; null: no joint"
    )


class CylinderDetector:
    """Judges a cylinder as extended (CONFIRMED), retracted (GONE), or between the two (PARTIAL).

    Extended: its position bit is on, or the pressure is at least 85 % of the supply pressure for 100 ms. Retracted:
    less than 50 kPa for 200 ms, and the extended bit is not on. If no pressure is carried, the retracted bit proves
    "retracted"; without that bit, an extended bit that is off proves it.
    """

    MEMORY: ClassVar = {"_held": bool, "_high": NESTED, "_low": NESTED, "level": Evidence}

    def __init__(self, actuator: CylinderActuator, supply: Supply) -> None:
        self._actuator, self._supply = actuator, supply
        self._extended_us, self._retracted_us = to_us(actuator.extended_s), to_us(actuator.retracted_s)
        self._held = False
        self._high, self._low = Streak(), Streak()
        self.level = Evidence.UNKNOWN

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence after one more sample at ``at`` µs."""
        actuator, high, low, read = self._actuator, self._high, self._low, readings.fresh.get
        pressure = read(actuator.channel)
        extended, retracted = read(actuator.extended_bit or ""), read(actuator.retracted_bit or "")
        lacking = pressure is None and (
            actuator.channel in readings.carried or (extended is None and retracted is None)
        )
        if lacking and not extended:
            return self.expire()
        if pressure is not None and actuator.channel in readings.arrived:
            for streak, holds in (
                (high, pressure >= self._threshold_pa(readings)),
                (low, pressure < actuator.retracted_kpa * 1000),
            ):
                if holds:
                    streak.take(True, at)
                else:
                    streak.samples = 0
        if extended or (high.samples and high.lasted(at, self._extended_us)):
            self._held = True
            self.level = Evidence.CONFIRMED
        elif not (self._held and high.samples):
            # what was confirmed and still stands at its pressure is not lost: it is being confirmed again
            self._held = False
            if pressure is not None:
                gone = low.lasted(at, self._retracted_us)
            elif retracted is None:  # a bit that is carried would say so, and does not
                gone = not extended and actuator.retracted_bit not in readings.carried
            else:
                gone = bool(retracted)
            self.level = Evidence.GONE if gone else Evidence.PARTIAL
        return self.level

    def expire(self) -> Evidence:
        """Return UNKNOWN and restart the counts, because no fresh reading is available."""
        self._high, self._low = Streak(), Streak()
        self.level = Evidence.UNKNOWN
        return self.level

    def _threshold_pa(self, readings: ChannelReadings) -> float:
        supply_pa = self._supply.pressure_pa(readings.fresh.get(self._supply.channel))
        # 85 % of no air at all is nothing: with less than a grip needs, the pressure of a rod at rest is no proof
        supply_pa = max(supply_pa, self._supply.refuse_kpa * 1000)
        # a little lower once extended: noise at the threshold is no loss
        margin_pa = self._supply.hysteresis_kpa * 1000 if self._held else 0.0
        return self._actuator.extended_fraction * supply_pa - margin_pa


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
    margin_from = "confirmed"
    moves = True

    def detector(self, actuator: CylinderActuator, supply: Supply) -> CylinderDetector:
        """Return a detector that judges the pressure and the position bits."""
        return CylinderDetector(actuator, supply)

    def margin_pa(self, actuator: CylinderActuator, gauge_pa: float, supply_pa: float) -> float:
        """Return the distance above the threshold of confirmation, Pa."""
        return gauge_pa - actuator.extended_fraction * supply_pa

    def lost(self, actuator: CylinderActuator, readings: ChannelReadings, at: int) -> str:
        """Return the remaining pressure and the required one."""
        value = readings.get(actuator.channel, at)
        if value is None or isinstance(value, bool):
            return super().lost(actuator, readings, at)
        return f"{value / 1000:.0f} kPa, {actuator.extended_fraction:.0%} of the supply pressure required"

    def not_fitted(self, actuator: CylinderActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield for each missing sensor which other one proves the position, and what is not detected."""
        if actuator.channel not in carried:
            proof = f"only {actuator.extended_bit} confirms that it is extended, thresholds are off"
            yield f"channel: {actuator.channel}: {proof}: lost air is not detected"
        for key, bit in (("extended_bit", actuator.extended_bit), ("retracted_bit", actuator.retracted_bit)):
            if bit not in carried:
                yield f"{key}: {bit or NO_CHANNEL}: {self._instead(actuator, key.removesuffix('_bit'), carried)}"

    def limits(self, actuator: CylinderActuator, supply: Supply) -> dict[str, float]:
        """Return the thresholds at the nominal supply pressure, kPa."""
        extended_kpa = actuator.extended_fraction * supply.nominal_kpa
        lost_kpa = extended_kpa - supply.hysteresis_kpa
        return {"confirmed_kpa": extended_kpa, "gone_kpa": actuator.retracted_kpa, "lost_kpa": lost_kpa}

    def travel(self, actuator: CylinderActuator) -> Travel | None:
        """Return the stroke as a prismatic joint; None: the stanza does not define it."""
        return None if actuator.stroke_mm is None else Travel("prismatic", actuator.stroke_mm / 1000)

    def _instead(self, actuator: CylinderActuator, position: str, carried: Mapping[str, Kind]) -> str:
        if actuator.channel in carried:
            return f"only the pressure {actuator.channel} confirms that it is {position}: a stuck rod is not detected"
        if position == "extended":
            return "extended cannot be proven"
        return "retracted is assumed to be the opposite of extended: a rod that stops on its way counts as retracted"
