"""Watches a held part: a weak grip, a leak, lost readings, the supply. It never releases the part."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import attrgetter
from typing import ClassVar

from end_effector_hal.codecs import Carrier, period_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import HoldFinding, HoldWatch, fault_of, is_guarded, kind_of
from end_effector_hal.signals import NESTED, ChannelReadings
from end_effector_hal.vocabulary import LEAK, Alarm, Evidence

from ._alarms import DEVICE_ALARMS, FAILED, AlarmLog
from ._device_faults import refuses
from ._sensor_set import SensorSet, why_invalid

_SECURE = attrgetter("secure")


class HoldMonitor:
    """Collects alarms about a held part; they stay until a Drop, or until they are over and acknowledged.

    The readings of every actuator are watched; its kind defines what else is watched. A fault reported by a device is
    an alarm whether a part is held or not, and no Drop ends it.

    Args:
        description: the tool.
        senses: its detectors, which must have processed a sample before this monitor does.
        carrier: carries its channels.
    """

    MEMORY: ClassVar = {"_log": NESTED, "_of_parts": NESTED, "_since": int | None}

    def __init__(self, description: Description, senses: SensorSet, carrier: Carrier) -> None:
        self._description, self._senses, self._hold = description, senses, description.hold
        self._devices = senses.now.faults.channels
        self._names = description.sequence
        self._log = AlarmLog()
        self._of_parts = tuple(
            self._watches_of(tool, description.uses(name), carrier)
            for name, tool in zip(description.part_names, description.per_part, strict=True)
        )
        self._guarded = tuple(
            (self._names[index], watch)
            for watches in self._of_parts
            for index, watch in watches.items()
            if is_guarded(watch)
        )
        self._since: int | None = None

    def _watches_of(self, tool: Description, used: Sequence[bool], carrier: Carrier) -> dict[int, HoldWatch]:
        watches = (
            kind_of(actuator).hold_watch(actuator, self._hold, period_of(carrier, actuator.channel))
            if uses
            else None
            for (_, actuator), uses in zip(tool.ordered, used, strict=True)
        )
        return {index: watch for index, watch in enumerate(watches) if watch is not None}

    @property
    def _watches(self) -> dict[int, HoldWatch]:
        """The watches over the part that is held."""
        return self._of_parts[self._senses.now.part]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """All alarms; a plug-in watch that has failed remains an alarm."""
        return self._log.listed

    @property
    def secure(self) -> bool:
        """Whether every actuator is confirmed by a fresh reading, and secure where its kind has a watch."""
        return self._senses.now.confirmed and all(map(_SECURE, self._watches.values()))

    def watch_over(self, index: int) -> HoldWatch | None:
        """Return the watch over an actuator, by its position in the sequence; None: it has none."""
        return self._watches.get(index)

    @property
    def allows_lift(self) -> bool:
        """Whether no watch prevents lifting the held and confirmed part."""
        return not self._log.active(LEAK) and (self._hold.lift_needs == "confirmed" or self.secure)

    def sample(self, at: int, *, held: bool, readings: ChannelReadings | None = None) -> bool:
        """Process the newest sample, at ``at`` µs; return True if there is something new to report.

        Args:
            at: time of the sample, µs.
            held: whether a part is held.
            readings: readings of a sample that the detectors skip because it changes nothing for them.
        """
        now, log = self._senses.now, self._log
        watches = self._of_parts[now.part]
        was_secure = all(map(_SECURE, watches.values()))
        listed = log.listed
        for watch in watches.values():
            watch.sample(readings or now.readings, at, held=self._since is not None)
        if not held:
            self._since = None
        else:
            self._since = at if self._since is None else self._since
            if Evidence.UNKNOWN in now.evidence or (listed and log.active("evidence.unread")):
                for index, name in enumerate(self._names):
                    if now.used[index]:
                        self._readable(index, name, at)
            for index, watch in watches.items():
                if now.evidence[index] is Evidence.CONFIRMED:
                    self._log_findings(self._names[index], watch.findings(self._since, at), at)
            if now.supply.low or listed:
                self._supply(at)
        if self._devices:
            self._device_faults(at)
        for name, each in self._guarded:
            if fault := fault_of(each):
                log.raise_(Alarm(FAILED, name, {"what": "watched", "why": fault}, at))
        newly_secure = all(map(_SECURE, watches.values())) is not was_secure and now.confirmed
        return newly_secure or log.listed != listed

    def tool(self, loose: str, at: int) -> bool:
        """Update why the tool of a held part is not proven locked (IL-05), a clause; empty: it is.

        Return whether this is new.
        """
        if loose:
            return self._log.raise_(Alarm("changer.loose", "", {"interlock": "IL-05", "why": loose}, at))
        return self._log.end("changer.loose", "")

    def fault(self, at: int) -> str:
        """Return why no grip may begin: a device's fault that is present or latched; empty: none."""
        faults, readings = self._senses.now.faults, self._senses.now.readings
        logged = self._log.of_id(*DEVICE_ALARMS) if self._devices else {}
        for name, alarm in logged.items():
            known = faults.named(name)
            if known and refuses(known.alarm):
                return f"{alarm}{' Reset it first.' if alarm.over else ''}"
        for channel in faults.unknown(readings, at) if self._devices else ():
            if channel in faults.refusing():
                return f"{channel} has no valid reading: its fault status is unknown; check the link."
        return ""

    def acknowledge(self) -> None:
        """Remove the alarms that are over, because an operator has seen them; active ones stay."""
        self._log.acknowledge()

    def dropped(self) -> None:
        """Remove the alarms about the part, because a Drop was accepted and nothing is held any more."""
        self._log.clear()
        for watch in self._watches.values():
            watch.dropped()

    def _log_findings(self, name: str, findings: Iterable[HoldFinding], at: int) -> None:
        for finding in findings:
            if not finding.over:
                self._log.raise_(Alarm(finding.id, name, finding.values, at))
            elif self._log.listed:
                self._log.end(finding.id, name, finding.values)

    def _device_faults(self, at: int) -> None:
        """Begin the alarms of present faults; end those whose channel has a fresh reading without it."""
        faults, readings = self._senses.now.faults, self._senses.now.readings
        standing = {each.name: each for each in faults.standing(readings, at)}
        for each in standing.values():
            self._log.raise_(each.as_alarm(at))
        unknown = faults.unknown(readings, at)
        for name in self._log.of_id(*DEVICE_ALARMS).keys() - standing.keys():
            known = faults.named(name)
            if known is None or known.channel in unknown:
                continue
            if known.alarm.latches:
                self._log.end(known.id, name, known.values)
            else:
                self._log.forget(known.id, name)

    def _readable(self, index: int, name: str, at: int) -> None:
        if self._senses.now.evidence[index] is Evidence.UNKNOWN:
            readings, actuator = self._senses.now.readings, self._description.actuators[name]
            channels = kind_of(actuator).channel_names(actuator)
            sent = next((each for each in channels if readings.sent_invalid(each, at)), "")
            why = {"why": why_invalid(self._description, sent)} if sent else {}
            self._log.raise_(Alarm("evidence.unread", name, why, at))
        else:
            self._log.end("evidence.unread", name)

    def _supply(self, at: int) -> None:
        supply = self._senses.now.supply
        if supply.low and supply.kpa is not None:
            values = {"warn_kpa": self._description.supply.warn_kpa, "kpa": supply.kpa}
            self._log.raise_(Alarm("supply.low", "", values, at))
        elif not supply.low:
            self._log.end("supply.low", "")
