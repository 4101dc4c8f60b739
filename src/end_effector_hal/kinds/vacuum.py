"""The device kind ``vacuum``, a generator with its cups: its keys, its evidence, and the watch over a held part.

The defaults are those of the paper's tool, and of Schmalz's data sheets where the paper has no value. Evidence and
security of a grip come from vacuum samples by thresholds, hysteresis and consecutive samples. A held part is watched
for a weak grip and for a leak.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from end_effector_hal.kinds import (
    COMPRESSED_AIR,
    ChannelKey,
    ChannelReadings,
    Detector,
    DeviceKind,
    HoldFinding,
    JointRule,
    PressureRange,
    Quote,
    below_ambient_kpa,
)
from end_effector_hal.kinds.conditions import part_conditions
from end_effector_hal.kinds.stanza import (
    NO_CHANNEL,
    Actuator,
    BelowAmbient,
    BlowOff,
    EvidenceConditions,
    Hold,
    Name,
    Samples,
    Settling,
    Supply,
    named,
)
from end_effector_hal.signals import NESTED, Kind, Streak, Trend
from end_effector_hal.vocabulary import LEAK, WEAK, Evidence, TableState, to_us


class VacuumActuator(Actuator):
    """A vacuum generator with its cups, proven by pressure or by switches (`part_bit`, `gone_bit`)."""

    kind: Literal["vacuum"] = Field(description="what it is")
    blow_off: BlowOff | None = Field(default=None, description="absent: none is fitted")
    confirmed_kpa: BelowAmbient = Field(
        default=55.0, description="at least this far below ambient: confirmed"
    )
    confirmed_samples: Samples = Field(default=3, description="consecutive samples that confirm")
    gone_kpa: BelowAmbient = Field(default=10.0, description="less than this: gone")
    lost_kpa: BelowAmbient = Field(default=50.0, description="less than this, once confirmed: lost")
    lost_samples: Samples = Field(
        default=2, description="consecutive samples below lost_kpa that count as lost"
    )
    lost_at_once_kpa: BelowAmbient = Field(
        default=20.0, description="less than this, once confirmed: lost at once"
    )
    secure_kpa: BelowAmbient = Field(default=75.0, description="at least this: a secure grip")
    secure_hysteresis_kpa: BelowAmbient = Field(
        default=15.0, description="no longer secure this far below secure_kpa"
    )
    part_bit: Name | None = Field(
        default=None,
        description="vacuum switch that is on with a part; it decides, whatever channel shows; null: none",
    )
    gone_bit: Name | None = Field(
        default=None,
        description="with part_bit: switch that is on without vacuum; null or none: part_bit off proves a release",
    )
    confirmed_ms: Settling = Field(default=50, description="part_bit for this long: confirmed")
    lost_ms: Settling = Field(default=40, description="once confirmed: part_bit off for this long: lost")
    gone_ms: Settling = Field(
        default=100, description="part_bit off, and gone_bit on where it is named, for this long: gone"
    )


class VacuumDetector:
    """Judges one vacuum circuit as confirmed, partial or gone, from its pressure.

    A confirmed vacuum stays confirmed down to ``lost_kpa``, also across an interruption of the link: afterwards
    ``lost_kpa`` is enough to confirm it again, because a short silence must not look like a loss.
    """

    MEMORY: ClassVar = {"_held": bool, "_above": NESTED, "_below": NESTED, "level": Evidence}

    def __init__(self, actuator: VacuumActuator) -> None:
        self._actuator = actuator
        self._held = False
        self._above = Streak()
        self._below = Streak()
        self.level = Evidence.UNKNOWN

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence after one more sample at ``at`` µs."""
        actuator, above, below = self._actuator, self._above, self._below
        value = readings.fresh.get(actuator.channel)
        if value is None:
            return self.expire()
        if actuator.channel not in readings.arrived:
            return self.level
        kpa = -value / 1000 if type(value) is int else below_ambient_kpa(value)
        least_kpa = actuator.lost_kpa if self._held else actuator.confirmed_kpa
        above.samples = above.samples + 1 if kpa >= least_kpa else 0
        below.samples = below.samples + 1 if kpa < actuator.lost_kpa else 0
        if self._held:
            if kpa < actuator.lost_at_once_kpa or below.samples >= actuator.lost_samples:
                self._held = False
            elif above.samples >= actuator.confirmed_samples:
                self.level = Evidence.CONFIRMED
        elif above.samples >= actuator.confirmed_samples:
            self._held = True
            self.level = Evidence.CONFIRMED
        if not self._held:
            self.level = Evidence.GONE if kpa < actuator.gone_kpa else Evidence.PARTIAL
        return self.level

    def expire(self) -> Evidence:
        """Return UNKNOWN and restart the counts, because no fresh reading is available."""
        self._above, self._below = Streak(), Streak()
        self.level = Evidence.UNKNOWN
        return self.level


LASTS = 0.25
"""Share of the trend window for which a leak must be seen before it is reported."""
RELIEF = 1.5
"""A leak is over if for a whole window the loss was at least this factor times ``warn_ahead_s`` away."""


class VacuumWatch:
    """Watches one vacuum circuit.

    A grip is secure from ``secure_kpa`` on, until the hysteresis is used up; a single sample decides nothing. With a
    bit instead of a pressure it is secure while the bit is on.
    """

    MEMORY: ClassVar = {
        "_high": NESTED,
        "_low": NESTED,
        "_was_deep": bool,
        "trend": NESTED,
        "leaks": NESTED,
        "keeps": NESTED,
        "kpa": float | None,
        "secure": bool,
        "was_secure": bool,
        "judged": bool,
    }

    def __init__(self, actuator: VacuumActuator, hold: Hold, period_us: int) -> None:
        self._actuator, self._hold = actuator, hold
        self.least_kpa = actuator.secure_kpa - actuator.secure_hysteresis_kpa
        """Limit below which a grip is no longer secure, kPa below ambient."""
        self._high, self._low = Streak(), Streak()
        self._was_deep = False  # before a silence as well: only new samples change it
        self.trend = Trend(to_us(hold.trend_s), period_us)
        self.leaks, self.keeps = Streak(), Streak()
        self.kpa: float | None = None
        self.secure = self.was_secure = self.judged = False

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Process the newest reading, at ``at`` µs."""
        actuator, high, low, trend = self._actuator, self._high, self._low, self.trend
        value = readings.fresh.get(actuator.channel)
        if value is None or isinstance(value, bool):
            self._expire()
            self.secure = value is True
        elif actuator.channel in readings.arrived:
            self.kpa = kpa = -value / 1000
            high.samples = high.samples + 1 if kpa >= actuator.secure_kpa else 0
            low.samples = low.samples + 1 if kpa < self.least_kpa else 0
            if high.samples >= actuator.confirmed_samples:
                self._was_deep = True
            elif low.samples >= actuator.lost_samples:
                self._was_deep = False
            self.secure = self._was_deep
            if held:
                self.judged = trend.take(kpa, at)
            else:
                self.was_secure = False
                if trend.points or trend.samples:
                    trend.clear()

    def findings(self, since: int, at: int) -> Iterable[HoldFinding]:
        """Return findings about a weak grip and a leak, both while present and when ended."""
        if self.kpa is None:
            return ()
        leak = self._leak(self.kpa, at) if self.judged else None
        return filter(None, (self._weak(self.kpa, since, at), leak))

    @property
    def leak_kpa_s(self) -> float | None:
        """Fall of the vacuum, kPa/s; None: not known."""
        return self.trend.falls

    @property
    def lost_in_s(self) -> float | None:
        """Time until the vacuum is below the threshold of loss, s; None: never, or not known."""
        return None if self.kpa is None else self.trend.falls_by(self.kpa - self._actuator.lost_kpa)

    def dropped(self) -> None:
        """Discard the trend, because the next samples belong to another part."""
        self.trend.clear()

    def _expire(self) -> None:
        self.kpa, self.judged = None, False
        self._high, self._low = Streak(), Streak()
        self.trend.clear()
        self.leaks, self.keeps = Streak(), Streak()

    def _weak(self, kpa: float, since: int, at: int) -> HoldFinding | None:
        within_s = self._hold.secure_within_s
        if self.secure:
            self.was_secure = True
            return HoldFinding(WEAK, {"kpa": kpa}, over=True)
        if self.was_secure:
            return HoldFinding(WEAK, {"kpa": kpa, "least_kpa": self.least_kpa})
        if at - since < to_us(within_s):
            return None
        return HoldFinding(WEAK, {"kpa": kpa, "secure_kpa": self._actuator.secure_kpa, "within_s": within_s})

    def _leak(self, kpa: float, at: int) -> HoldFinding | None:
        hold, lost_kpa = self._hold, self._actuator.lost_kpa
        left_s = self.trend.falls_by(kpa - lost_kpa)
        self.leaks.take(left_s is not None and left_s < hold.warn_ahead_s, at)
        self.keeps.take(left_s is None or left_s >= RELIEF * hold.warn_ahead_s, at)
        if self.keeps.lasted(at, to_us(hold.trend_s)):
            return HoldFinding(LEAK, {"kpa": kpa}, over=True)
        if left_s is None or not self.leaks.lasted(at, to_us(LASTS * hold.trend_s)):
            return None
        falls = self.trend.falls or 0.0
        return HoldFinding(LEAK, {"falls": falls, "kpa": kpa, "lost_kpa": lost_kpa, "left_s": left_s})


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
    margin_from = "lost"
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

    def preset(self, actuator: VacuumActuator) -> EvidenceConditions | None:
        """Return the conditions over its switches; None: it has no part switch."""
        return part_conditions(actuator)

    def detector(self, actuator: VacuumActuator, supply: Supply) -> Detector:
        """Return a detector that judges the pressure, or the switches if there is a part switch."""
        return (
            VacuumDetector(actuator) if self.preset(actuator) is None else super().detector(actuator, supply)
        )

    def plausible(self, actuator: VacuumActuator) -> PressureRange:
        """Return the range of its pressure, which is wider with a blow-off: it adds compressed air."""
        high = COMPRESSED_AIR.high if actuator.blow_off is not None else HIGHEST_KPA
        return PressureRange(LOWEST_KPA, high, "a vacuum circuit")

    def margin_pa(self, actuator: VacuumActuator, gauge_pa: float, supply_pa: float) -> float:
        """Return the distance beyond the threshold of loss, Pa."""
        return -gauge_pa - actuator.lost_kpa * 1000

    def hold_watch(self, actuator: VacuumActuator, hold: Hold, period_us: int) -> VacuumWatch | None:
        """Return a watch for weak grips and leaks; None: only switches prove the part."""
        return (
            None
            if self.preset(actuator) and not named(actuator.channel)
            else VacuumWatch(actuator, hold, period_us)
        )

    def lost(self, actuator: VacuumActuator, readings: ChannelReadings, at: int) -> str:
        """Return the remaining vacuum and the required one."""
        value = readings.get(actuator.channel, at)
        if value is None or isinstance(value, bool) or self.preset(actuator):
            return super().lost(actuator, readings, at)
        return f"{-value / 1000:.1f} kPa below ambient, {actuator.lost_kpa:g} kPa required"

    def not_fitted(self, actuator: VacuumActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase for each thing that a switch without a second sensor does not detect."""
        if self.preset(actuator) is None:
            return
        if actuator.channel not in carried:
            proof = f"only {actuator.part_bit} shows a part"
            yield f"channel: {actuator.channel}: {proof}: a weak grip and a leak are not detected"
        if actuator.gone_bit not in carried:
            left = "what is left of a vacuum under its threshold is not seen"
            yield f"gone_bit: {actuator.gone_bit or NO_CHANNEL}: {actuator.part_bit} off counts as vented: {left}"

    def limits(self, actuator: VacuumActuator, supply: Supply) -> dict[str, float]:
        """Return the thresholds, kPa below ambient."""
        return {name: getattr(actuator, name) for name in _THRESHOLDS}
