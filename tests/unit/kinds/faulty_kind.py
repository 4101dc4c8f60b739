"""A kind of somebody else's that does what a vacuum does, but for what is broken in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Literal

from pydantic import Field

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds import ChannelReadings, HoldFinding
from end_effector_hal.kinds.stanza import Hold, Supply
from end_effector_hal.kinds.vacuum import Vacuum, VacuumActuator, VacuumDetector, VacuumWatch
from end_effector_hal.vocabulary import Evidence

broken: dict[str, Callable[[], Any]] = {}
"""What a method does instead, by the names of its class and its own."""


def or_broken(name: str, otherwise: Callable[[], Any]) -> Any:
    return broken.get(name, otherwise)()


class FaultyActuator(VacuumActuator):
    """A vacuum by another name."""

    kind: Literal["faulty"] = Field(description="what it is")  # type: ignore[assignment]


class FaultyDetector(VacuumDetector):
    MEMORY: ClassVar = VacuumDetector.MEMORY

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        level = VacuumDetector.sample
        found: Evidence = or_broken("FaultyDetector.sample()", lambda: level(self, readings, at))
        if "FaultyDetector.MEMORY" in broken:
            del self._held
        return found


class FaultyWatch(VacuumWatch):
    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        sample = VacuumWatch.sample
        or_broken("FaultyWatch.sample()", lambda: sample(self, readings, at, held=held))

    def findings(self, since: int, at: int) -> Iterator[HoldFinding]:
        findings = VacuumWatch.findings
        found: Iterator[HoldFinding] = or_broken("FaultyWatch.findings()", lambda: findings(self, since, at))
        return found

    def dropped(self) -> None:
        or_broken("FaultyWatch.dropped()", lambda: VacuumWatch.dropped(self))


class Faulty(Vacuum):
    name = "faulty"
    stanza = FaultyActuator

    def detector(self, actuator: VacuumActuator, supply: Supply) -> VacuumDetector:
        found: VacuumDetector = or_broken("Faulty.detector()", lambda: FaultyDetector(actuator))
        return found

    def hold_watch(self, actuator: VacuumActuator, hold: Hold, period_us: int) -> VacuumWatch:
        found: VacuumWatch = or_broken("Faulty.hold_watch()", lambda: FaultyWatch(actuator, hold, period_us))
        return found

    def plausible(self, actuator: VacuumActuator) -> Any:
        return or_broken("Faulty.plausible()", lambda: Vacuum.plausible(self, actuator))

    def margin_pa(self, actuator: VacuumActuator, gauge_pa: float, supply_pa: float) -> Any:
        return or_broken("Faulty.margin_pa()", lambda: Vacuum.margin_pa(self, actuator, gauge_pa, supply_pa))

    def lost(self, actuator: VacuumActuator, readings: ChannelReadings, at: int) -> Any:
        return or_broken("Faulty.lost()", lambda: Vacuum.lost(self, actuator, readings, at))

    def limits(self, actuator: VacuumActuator, supply: Supply) -> Any:
        return or_broken("Faulty.limits()", lambda: Vacuum.limits(self, actuator, supply))

    def channel_names(self, actuator: VacuumActuator) -> Any:
        return or_broken("Faulty.channel_names()", lambda: Vacuum.channel_names(self, actuator))


def described() -> Description:
    """The shipped tool; its last vacuum is of this kind."""
    shipped = load(profile_path())
    keys = shipped.actuators["top_vacuum"].model_dump() | {"kind": "faulty"}
    actuators = {**shipped.actuators, "top_vacuum": FaultyActuator.model_validate(keys)}
    return shipped.model_copy(update={"actuators": actuators})
