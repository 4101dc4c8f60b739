# ruff: noqa: D102 the name of a test says what must hold
"""Tests that every kind of device must pass; inherit `KindConformance` in your tests (needs pytest).

class TestJaw(KindConformance):
    kind = Jaw()
    stanza = {"line": "JAW"}
    active = {"jaw_closed": True, "jaw_open": False}
    inactive = {"jaw_closed": False, "jaw_open": True}
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, ClassVar

from end_effector_hal.signals import Kind, Value, memory_of, recall
from end_effector_hal.vocabulary import ACTIVE, INACTIVE, PENDING, Evidence

from ._kind import DeviceKind
from ._registry import checked
from .stanza import NO_CHANNEL, Actuator, Hold, Supply

PERIOD_US = 20_000
LONGEST_US = 60_000_000
"""Longest wait for an evidence while the readings do not change, µs."""


class FixedReadings:
    """Constant readings of one actuator's channels and the supply, as if one frame had delivered them."""

    def __init__(self, values: Mapping[str, Value]) -> None:
        self.values = values
        self.fresh = {name: value for name, value in values.items() if value is not None}
        self.arrived = frozenset(self.fresh)

    @property
    def carried(self) -> Mapping[str, Kind]:
        bits = {name: isinstance(value, bool) for name, value in self.values.items()}
        return {name: Kind.BIT if bit else Kind.PRESSURE for name, bit in bits.items()}

    def get(self, channel: str | None, at: int) -> int | bool | None:
        return None if channel is None else self.fresh.get(channel)


class KindConformance:
    """The tests of a kind.

    A subclass sets ``kind``; ``stanza``: the required keys; ``active`` and ``inactive``: the values of its channels in
    these states.
    """

    kind: ClassVar[DeviceKind[Any]]
    stanza: ClassVar[Mapping[str, object]]
    active: ClassVar[Mapping[str, Value]]
    inactive: ClassVar[Mapping[str, Value]]
    supply = Supply()

    @property
    def actuator(self) -> Actuator:
        return self.kind.stanza.model_validate({"kind": self.kind.name, **self.stanza})

    def readings(self, values: Mapping[str, Value]) -> FixedReadings:
        return FixedReadings({self.supply.channel: round(self.supply.nominal_kpa * 1000), **values})

    def judged(
        self, detector: Any, values: Mapping[str, Value], expected: Evidence, at: int = 0
    ) -> tuple[Evidence, int]:
        """Return the evidence and its time: as soon as it is the expected one, else after a minute."""
        readings, level = self.readings(values), Evidence.UNKNOWN
        for at in range(at + PERIOD_US, at + LONGEST_US, PERIOD_US):  # noqa: B020 goes on from there
            level = detector.sample(readings, at)
            if level is expected:
                break
        return level, at

    def new_detector(self) -> Any:
        return self.kind.detector(self.actuator, self.supply)

    def test_declares_what_it_is(self) -> None:
        assert checked(self.kind) is self.kind
        assert self.kind.stanza.__doc__

    def test_every_key_has_a_meaning(self) -> None:
        lacking = [key for key, each in self.kind.stanza.model_fields.items() if not each.description]
        assert not lacking or lacking == ["kind"]

    def test_its_states_stand_for_inactive_pending_active(self) -> None:
        labels = [self.kind.states(state).label for state in (INACTIVE, PENDING, ACTIVE)]
        assert len(set(labels)) == 3

    def test_its_channels_are_named_in_the_vectors(self) -> None:
        names = {name for name in self.kind.channel_names(self.actuator) if name != NO_CHANNEL}
        assert names == set(self.active) == set(self.inactive)

    def test_the_defaults_keep_its_own_rules(self) -> None:
        actuator = self.actuator
        for low, relation, high in self.kind.orders:
            less, more = getattr(actuator, low), getattr(actuator, high)
            assert less < more or (relation == "<=" and less == more), (low, relation, high)
        for rule in self.kind.joint_rules:
            numbers = {key: self._number(key) for key in rule.keys}
            assert rule.fault("it", numbers, str) is None

    def test_is_confirmed_when_it_is_active_and_gone_when_it_is_not(self) -> None:
        detector = self.new_detector()
        level, at = self.judged(detector, self.active, Evidence.CONFIRMED)
        assert level is Evidence.CONFIRMED
        level, at = self.judged(detector, self.inactive, Evidence.GONE, at)
        assert level is Evidence.GONE
        assert self.judged(detector, self.active, Evidence.CONFIRMED, at)[0] is Evidence.CONFIRMED

    def test_nothing_is_proven_without_a_reading(self) -> None:
        lost = dict.fromkeys(self.active)
        for before, level in ((self.active, Evidence.CONFIRMED), (self.inactive, Evidence.GONE)):
            detector = self.new_detector()
            assert detector.sample(self.readings(lost), 0) is Evidence.UNKNOWN
            _, at = self.judged(detector, before, level)
            assert detector.sample(self.readings(lost), at + PERIOD_US) is Evidence.UNKNOWN

    def test_a_detector_can_be_recorded_and_recalled(self) -> None:
        one, other = self.new_detector(), self.new_detector()
        _, at = self.judged(one, self.active, Evidence.CONFIRMED)
        recall(other, memory_of(one))
        assert memory_of(other) == memory_of(one)
        for values in (self.active, self.inactive):
            at += PERIOD_US
            assert one.sample(self.readings(values), at) is other.sample(self.readings(values), at)

    def test_what_the_vectors_show_is_plausible(self) -> None:
        span = self.kind.plausible(self.actuator)
        for values in (self.active, self.inactive):
            value = values.get(self.actuator.channel)
            assert value is None or isinstance(value, bool) or span.has(value)

    def test_its_pressure_is_on_the_right_side_when_active_and_on_the_wrong_one_when_not(self) -> None:
        for values, right in ((self.active, True), (self.inactive, False)):
            value = values.get(self.actuator.channel)
            if value is not None and not isinstance(value, bool):
                margin_pa = self.kind.margin_pa(self.actuator, value, self.supply.nominal_kpa * 1000)
                assert (margin_pa > 0) is right

    def test_its_watch_finds_a_held_part_secure_in_the_end(self) -> None:
        watch = self.kind.hold_watch(self.actuator, Hold(), PERIOD_US)
        if watch is None:
            return
        findings = []
        for at in range(0, 5_000_000, PERIOD_US):
            watch.sample(self.readings(self.active), at, held=True)
            findings += [each for each in watch.findings(0, at) if not each.over]
        assert watch.secure
        assert not findings
        other = self.kind.hold_watch(self.actuator, Hold(), PERIOD_US)
        assert other is not None
        recall(other, memory_of(watch))
        assert memory_of(other) == memory_of(watch)

    def test_its_words_are_sentences_of_one_line(self) -> None:
        carried = self.readings(self.active).carried
        said = [self.kind.lost(self.actuator, self.readings(values), 0) for values in (self.inactive, {})]
        said += [*self.kind.not_fitted(self.actuator, carried), *self.kind.not_fitted(self.actuator, {})]
        assert all(text and text.isprintable() for text in said)

    def test_its_limits_are_positive_numbers(self) -> None:
        limits = self.kind.limits(self.actuator, self.supply)
        assert all(isinstance(each, int | float) and each > 0 for each in limits.values())
        assert not limits.keys() & {"channel", "kind", "attempts"}

    def test_its_travel_is_a_length_or_an_angle(self) -> None:
        travel = self.kind.travel(self.actuator)
        assert travel is None or (travel.joint in ("prismatic", "revolute") and 0 < travel.upper < inf)

    def _number(self, key: str) -> float:
        owner = self.supply if key.startswith("supply.") else self.actuator
        number: float = getattr(owner, key.removeprefix("supply."))
        return number
