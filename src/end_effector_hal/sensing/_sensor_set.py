"""Turns frames and time into events of the model."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter
from typing import TYPE_CHECKING, ClassVar

from end_effector_hal.codecs import Carrier
from end_effector_hal.description import Description, used_channels
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.conditions import shown
from end_effector_hal.signals import INLINE, NESTED, Frame, Kind, StampGate, lengthen, streaks_of
from end_effector_hal.vocabulary import EMPTY, Alarm, Evidence, ToolEvidence, display_name

from ._sensor_state import SensorState

if TYPE_CHECKING:
    from timed_automata import Event

_EVIDENCE_CHANNELS = {
    Evidence.UNKNOWN: "stale",
    Evidence.GONE: "gone",
    Evidence.PARTIAL: "partial",
    Evidence.CONFIRMED: "confirmed",
}
# Of what one frame shows, nothing is decided before it is known what else it has undone.
_RANK = {Evidence.UNKNOWN: 0, Evidence.PARTIAL: 1, Evidence.GONE: 2, Evidence.CONFIRMED: 3}


SENT_INVALID = "frames come, and say that the value is invalid or beyond its range"
"""Reason why a channel has no value although the link works: the sensor must be checked."""


def why_invalid(description: Description, channel: str) -> str:
    """Return why a channel that is read has no value, as far as its source shows it."""
    each = description.channels.get(channel)
    if each and (place := each.modbus):
        register = " register" if place.register_type in ("holding", "input") else ""
        table = place.register_type.replace("_", " ") + register
        return f"unit {place.unit}, {table} {place.address} does not answer, refuses, or is beyond its range"
    if each and each.analog:
        return f"{each.analog.channel} of {each.analog.device} cannot be read, or is beyond its range"
    return f"the line {each.digital.line} cannot be read" if each and each.digital else SENT_INVALID


_Proven = tuple[tuple[Evidence, ...], ToolEvidence, tuple[int, ...]]
"""Evidence of the actuators, of the tool, and the actuators that have gripped nothing."""


class SensorSet:
    """Turns samples into levels, and each change of a level into an event.

    Args:
        description: the tool.
        carrier: carries its channels.
    """

    MEMORY: ClassVar = {"now": INLINE, "stamps": NESTED, "revision": int}

    def __init__(self, description: Description, carrier: Carrier) -> None:
        from timed_automata import Event  # the line arbiter does without

        self.now = SensorState(description, carrier)
        """The present evidence of the sensors."""
        self._description = description
        self.stamps = StampGate("Sensor frames", old_us=self.now.readings.stale_us, in_order=True)
        """Refuses frames because of their stamp."""
        self._wanted = tuple(name for name in used_channels(description) if name in carrier.channels)
        self._channels = {
            name: frozenset(
                channel
                for tool in description.per_part
                for channel in kind_of(tool.actuators[name]).channel_names(tool.actuators[name])
            )
            for name in description.sequence
        }
        self._ordered, self._named = description.ordered, bool(description.named_links)
        self._due: tuple[object, int, int | None] = None, 0, None
        self.revision = 0
        """Counter that grows whenever something may have changed."""
        self._evidence_events = tuple(
            {
                level: Event(f"{channel}[{index}]", {f"evidence[{index}]": int(level)})
                for level, channel in _EVIDENCE_CHANNELS.items()
            }
            for index in range(len(self.now.evidence))
        )
        self._empty_events = tuple(Event(f"empty[{index}]") for index in range(len(self.now.evidence)))
        self._tool_events = {
            level: Event(f"tool_is[{int(level)}]", {"tool": int(level)}) for level in ToolEvidence
        }

    @property
    def events(self) -> tuple[Event, ...]:
        """Every event that a frame or a silence can lead to."""
        evidence = (event for of_level in self._evidence_events for event in of_level.values())
        return (*evidence, *self._empty_events, *self._tool_events.values())

    @property
    def levels(self) -> dict[str, int]:
        """Levels of the model without an event; they are read when a command comes."""
        now = self.now
        return {
            "supply_ok": int(now.supply.ok),
            "vented": int(now.nothing_gripped),
            "parked": int(now.in_stand),
        }

    def grip_event(self, part: int) -> Event:
        """Return the event that begins a grip of a part, with what the newest readings prove by its values.

        Args:
            part: position of the part in the description.
        """
        from timed_automata import Event

        evidence = self.now.evidence_of(part)
        levels = {f"evidence[{i}]": int(level) for i, level in enumerate(evidence)}
        return Event("grip", {**levels, "wanted": part})

    def use(self, part: int) -> list[Event]:
        """Judge by the values of a part from now on; return the events of what they prove otherwise."""
        if part == self.now.part:
            return []
        before = self.now.evidence, self.now.tool, self.now.emptied
        self.now.use(part)
        return self._changed_from(before)

    @property
    def conclusive(self) -> bool:
        """Whether every actuator is proven to be confirmed or gone, which is enough to adopt."""
        return self.now.conclusive

    @property
    def at(self) -> int:
        """Time of the newest valid frame, µs.

        An older frame of another source that arrives later takes effect at this time.
        """
        return self.now.readings.last_frame

    def accepts(self, frame: Frame, now: int) -> bool:
        """Return whether the stamp of a frame received at ``now`` is valid; a refusal is reported."""
        source, stale_us = self.now.readings.origin(frame)
        passes = self.stamps.passes(frame.at, now, stale_us, source)
        if not passes:
            self.revision += 1
            self._due = None, 0, None
        return passes

    def frame(self, frame: Frame) -> list[Event]:
        """Return the events of one accepted frame.

        Their order is: losses, then GONE, then CONFIRMED, within these the sequence; then actuators that have gripped
        nothing.
        """
        now = self.now
        events: list[Event] = []
        before = now.evidence, now.tool, now.emptied
        for _ in now.take(frame):
            events += self._changed_from(before)
            before = now.evidence, now.tool, now.emptied  # the next change is made when it is requested
        return events

    def advance(self, at: int) -> list[Event]:
        """Return the events of readings that turned stale; call this method at :meth:`deadline`."""
        before = self.now.evidence, self.now.tool, self.now.emptied
        self.now.wait(at)
        return self._changed_from(before)

    def switch(self, index: int, at: int, *, active: bool) -> list[Event]:
        """Return the events of a command to an actuator, by its position in the sequence; see `OutputGate`."""
        before = self.now.evidence, self.now.tool, self.now.emptied
        self.now.switch(index, at, active=active)
        return self._changed_from(before)

    def pass_over(self, samples: int, at: int) -> None:
        """Account for frames that `stays` allowed to leave out, as if their samples had been counted.

        Args:
            samples: number of these frames.
            at: time of the last one, µs: the present evidence is as fresh as that.
        """
        lengthen(streaks_of(self.now), samples)
        self.now.readings.renew(at)
        self.revision += 1
        self._due = None, 0, None

    def deadline(self, at: int) -> int | None:
        """Return the time of the next change without a frame, µs; None: there is none."""
        read_at = self.now.readings.read_at
        of, asked_at, due = self._due
        if of is read_at and asked_at <= at and (due is None or at < due):
            return due  # several ask between two frames
        due = self.now.deadline(at)
        if self.stamps.refused and (ends := self.stamps.deadline(at)) is not None:
            due = ends if due is None else min(due, ends)
        self._due = read_at, at, due
        return due

    def notices(self, at: int, *, held: bool) -> tuple[Alarm, ...]:
        """Return the alarms about the readings at ``at`` µs.

        Alarms for a link that is down, and for an actuator of a held part without evidence, are made elsewhere.
        """
        said, readings = [*self.now.doubts(at)], self.now.readings
        if self.stamps.refused:
            said[:0] = self.stamps.notices(at)
        down = readings.down(at)
        if down and not self._named:
            return tuple(said)
        if self.now.conditional:
            said += self._findings(at)
        silent = {channel for source in down for channel in source.channels} if down else set[str]()
        stale = readings.stale(at)
        if not silent.issuperset(stale):
            silent |= self.now.mixed(at)
        lacking = [name for name in self._wanted if name in stale and name not in silent] if stale else []
        if not lacking and Evidence.UNKNOWN not in self.now.evidence:
            return tuple(said)
        settling = {self._ordered[i][0] for i, each in self.now.by_conditions if each.settles(at)}
        unknown = [
            name
            for name in self._unknown()
            if name not in settling and silent.isdisjoint(self._channels[name])
        ]
        told = {channel for name in unknown for channel in self._channels[name]} if held else set()
        missing = [name for name in lacking if name not in told]
        invalid = [name for name in missing if readings.sent_invalid(name, at)]
        if gone := [name for name in missing if name not in invalid]:
            said.append(Alarm("channel.unread", ", ".join(gone)))
        whys = {name: why_invalid(self._description, name) for name in invalid}
        for why in dict.fromkeys(whys.values()):
            names = ", ".join([name for name in invalid if whys[name] == why])
            said.append(Alarm("channel.unread", names, {"why": why}))
        if not held and (back := [name for name in unknown if not self._channels[name] & set(lacking)]):
            names = ", ".join(map(display_name, back))
            said.append(Alarm("evidence.settling", ", ".join(back), {"names": names}))
        return tuple(said)

    def _findings(self, at: int) -> Iterator[Alarm]:
        """Yield the alarms of detectors with conditions."""
        for index, detector in self.now.by_conditions:
            name, carried = self._ordered[index][0], self.now.readings.carried
            if detector.broken:
                bits = sorted(each for each in self._channels[name] if carried.get(each) is Kind.BIT)
                seen = shown(bits, self.now.readings, at)
                yield Alarm("evidence.contradicts", name, {"seen": seen})
            elif empty := self.now.empty(index):
                yield Alarm(EMPTY, name, {"empty": empty})

    def _unknown(self) -> list[str]:
        """Return the actuators without evidence."""
        pairs = zip(self._channels, self.now.evidence, strict=True)
        return [name for name, level in pairs if level is Evidence.UNKNOWN]

    def _changed_from(self, before: _Proven) -> list[Event]:
        """Return the events for all differences from the earlier evidence."""
        now = self.now
        events: list[Event] = []
        evidence, tool, emptied = before
        self.revision += 1
        if now.evidence != evidence:
            changed: list[tuple[int, int, Event]] = []
            for i, new in enumerate(now.evidence):
                if new is not evidence[i]:
                    changed.append((_RANK[new], i, self._evidence_events[i][new]))
            events = list(map(itemgetter(2), sorted(changed)))
        if now.emptied != emptied:
            events += [self._empty_events[i] for i in now.emptied if i not in emptied]
        if now.tool is not tool:
            events.append(self._tool_events[now.tool])
        return events
