"""What is watched while a part is held: a weak grip, a leak, lost readings, the supply. It never releases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import attrgetter
from typing import ClassVar

from end_effector_hal.codecs import Carrier, period_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import AlarmKind, HoldFinding, HoldWatch, fault_of, is_guarded, kind_of
from end_effector_hal.signals import PART, ChannelReadings
from end_effector_hal.vocabulary import Evidence, display_name

from ._alarms import AlarmLog
from ._device_faults import refuses
from ._sensor_set import SensorSet, why_invalid

_SECURE = attrgetter("secure")
KEPT = "outputs stay as they are, only a Drop releases"


class HoldMonitor:
    """Alarms about what is held; they stay until a Drop, or until they are over and acknowledged.

    Every actuator is watched for its readings; its kind says what else there is to watch. What a device says is wrong
    with it is an alarm whether anything is held or not, and no Drop ends it.

    Args:
        description: the tool.
        senses: its detectors, which have taken each sample before it is shown here.
        carrier: of its channels.
        devices: whether the alarms of devices are kept here.
    """

    MEMORY: ClassVar = {"_log": PART, "_watches": PART, "_since": int | None}

    def __init__(
        self, description: Description, senses: SensorSet, carrier: Carrier, *, devices: bool = True
    ) -> None:
        self._description, self._senses, self._hold = description, senses, description.hold
        self._devices = senses.now.faults.channels if devices else ()
        self._names = description.sequence
        self._log = AlarmLog()
        watches = (
            kind_of(part).hold_watch(part, self._hold, period_of(carrier, part.channel))
            for _, part in description.ordered
        )
        self._watches = {index: watch for index, watch in enumerate(watches) if watch is not None}
        self._guarded = tuple(
            (self._names[index], watch) for index, watch in self._watches.items() if is_guarded(watch)
        )
        self._since: int | None = None

    @property
    def alarms(self) -> tuple[str, ...]:
        """In words; a watch of somebody else's that has failed stays one."""
        return (*self._log.texts, *self._faults()) if self._guarded else self._log.texts

    def _faults(self) -> Iterator[str]:
        for name, watch in self._guarded:
            if fault := fault_of(watch):
                yield f"{display_name(name)} is not watched reliably: {fault}"

    @property
    def secure(self) -> bool:
        """Whether everything is confirmed by a fresh reading, and secure where its kind knows more than that."""
        return self._senses.now.confirmed and self._watched_secure

    def watch_over(self, index: int) -> HoldWatch | None:
        """What watches an actuator, by its place in the sequence; None: its evidence is enough."""
        return self._watches.get(index)

    @property
    def _watched_secure(self) -> bool:
        return all(map(_SECURE, self._watches.values()))

    @property
    def allows_lift(self) -> bool:
        """Whether nothing that is watched speaks against lifting what is held and confirmed."""
        return not self._log.active(AlarmKind.LEAK) and (self._hold.lift_needs == "confirmed" or self.secure)

    def sample(self, at: int, *, held: bool, readings: ChannelReadings | None = None) -> bool:
        """Look at the newest sample, at ``at`` µs; True when there is something new to tell.

        Args:
            at: of the sample.
            held: whether a part is.
            readings: of a sample that the detectors need not take, as it changes nothing that they show.
        """
        now, was_secure, told = self._senses.now, self._watched_secure, self.alarms
        for watch in self._watches.values():
            watch.sample(readings or now.readings, at, held=self._since is not None)
        if not held:
            self._since = None
        else:
            self._since = at if self._since is None else self._since
            for index, name in enumerate(self._names):
                self._readable(index, name, at)
            for index, watch in self._watches.items():
                if now.evidence[index] is Evidence.CONFIRMED:
                    name = self._names[index]
                    self._log_findings(name, watch.findings(display_name(name), self._since, at), at)
            self._supply(at)
        if self._devices:
            self._device_faults(at)
        newly_secure = now.confirmed and self._watched_secure is not was_secure
        return newly_secure or self.alarms != told

    def tool(self, loose: str, at: int) -> bool:
        """What speaks against it that the tool of a held part is locked (IL-05), a sentence; empty: nothing.

        Returns whether that is news.
        """
        if loose:
            return self._log.raise_(AlarmKind.TOOL, "", loose, at)
        return self._log.end(
            AlarmKind.TOOL, "", "The tool was not proven to be locked while a part was held."
        )

    def fault(self, at: int) -> str:
        """Why no grip begins: what a device says is wrong, or has said since the last reset; empty: nothing is."""
        faults, readings = self._senses.now.faults, self._senses.now.readings
        logged = self._log.of_kind(AlarmKind.DEVICE) if self._devices else {}
        for name, alarm in logged.items():
            known = faults.named(name)
            if known and refuses(known.alarm):
                return f"{alarm.text}{' Reset it first.' if alarm.over else ''}"
        for channel in faults.unknown(readings, at) if self._devices else ():
            if channel in faults.refusing():
                return f"{channel} has no valid reading: its fault status is unknown; check the link."
        return ""

    def acknowledge(self) -> None:
        """An operator has seen it: what is over is forgotten, what is not stays."""
        self._log.acknowledge()

    def dropped(self) -> None:
        """A Drop was accepted: nothing is held any more."""
        self._log.clear()
        for watch in self._watches.values():
            watch.dropped()

    def _log_findings(self, name: str, findings: Iterable[HoldFinding], at: int) -> None:
        for finding in findings:
            if finding.over:
                self._log.end(finding.kind, name, finding.text)
            else:
                self._log.raise_(finding.kind, name, finding.text, at)

    def _device_faults(self, at: int) -> None:
        """What stands begins; of what has a fresh reading without it, it is over."""
        faults, readings = self._senses.now.faults, self._senses.now.readings
        standing = {each.name: each for each in faults.standing(readings, at)}
        for name, each in standing.items():
            self._log.raise_(AlarmKind.DEVICE, name, each.text, at)
        unknown = faults.unknown(readings, at)
        for name in self._log.of_kind(AlarmKind.DEVICE).keys() - standing.keys():
            known = faults.named(name)
            if known is None or known.channel in unknown:
                continue
            if known.alarm.latches:
                self._log.end(AlarmKind.DEVICE, name, known.text)
            else:
                self._log.forget(AlarmKind.DEVICE, name)

    def _readable(self, index: int, name: str, at: int) -> None:
        unknown = self._senses.now.evidence[index] is Evidence.UNKNOWN
        if not unknown and not self._log.active(AlarmKind.STALE):
            return
        who = display_name(name)
        if unknown:
            readings, part = self._senses.now.readings, self._description.actuators[name]
            channels = kind_of(part).channel_names(part)
            sent = next((each for each in channels if readings.sent_invalid(each, at)), "")
            why = f" ({why_invalid(self._description, sent)})" if sent else ""
            text = f"No valid reading of {who} while it holds a part{why}; {KEPT}."
            self._log.raise_(AlarmKind.STALE, name, text, at)
        else:
            self._log.end(AlarmKind.STALE, name, f"{who} had no valid reading for a while; it is read again.")

    def _supply(self, at: int) -> None:
        supply = self._senses.now.supply
        if not supply.low and not self._log.active(AlarmKind.SUPPLY):
            return
        warn = f"{self._description.supply.warn_kpa:g} kPa"
        if supply.low and supply.kpa is not None:
            text = f"Low supply: under {warn} while a part is held ({supply.kpa:.0f} kPa)."
            self._log.raise_(AlarmKind.SUPPLY, "", text, at)
        elif not supply.low:
            self._log.end(
                AlarmKind.SUPPLY, "", f"The supply pressure was under {warn} while a part was held."
            )
