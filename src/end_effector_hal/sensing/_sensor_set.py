"""All detectors of a tool: frames and time in, events of the model out."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.codecs import Codec
from end_effector_hal.description import Description, used_channels
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import PART, Frame, StampGate
from end_effector_hal.vocabulary import Evidence, ToolEvidence, display_name
from timed_automata import Event

from ._link_rules import LinkRules
from ._readings import Readings
from ._supply_detector import SupplyDetector
from ._tool_detector import ToolDetector
from ._vented_detector import VentedDetector

_EVIDENCE_CHANNELS = {
    Evidence.UNKNOWN: "stale",
    Evidence.GONE: "gone",
    Evidence.PARTIAL: "partial",
    Evidence.CONFIRMED: "confirmed",
}
# Of what one frame shows, nothing is decided before it is known what else it has undone.
_RANK = (Evidence.UNKNOWN, Evidence.PARTIAL, Evidence.GONE, Evidence.CONFIRMED)


class SensorSet:
    """Stands between samples and events: a level each, and an event at each change of one."""

    MEMORY: ClassVar = {
        "readings": PART,
        "_rules": PART,
        "_stamps": PART,
        "_detectors": PART,
        "_tool": PART,
        "_vented": PART,
        "supply": PART,
        "_noticed": tuple[str, ...],
        "_was_clear": bool,
        "evidence": list[Evidence],
        "tool": ToolEvidence,
        "vented": bool,
        "parked": bool,
        "looked": int,
    }

    def __init__(self, description: Description, codec: Codec) -> None:
        self.readings = Readings(description.link, codec)
        self._rules = LinkRules(description, codec, self.readings.stale_us)
        self._stamps = StampGate("Sensor frames", old_us=self.readings.stale_us, in_order=True)
        self._wanted = tuple(name for name in used_channels(description) if name in codec.channels)
        self._channels = {
            name: frozenset(kind_of(part).channel_names(part)) for name, part in description.ordered
        }
        self._noticed: tuple[str, ...] = ()
        self._detectors = tuple(
            kind_of(part).detector(part, description.supply) for _, part in description.ordered
        )
        changer = description.tool_changer
        self._tool = ToolDetector(changer) if changer else None
        self._stand = (changer.stand_bit, changer.present_bit) if changer else None
        bits = (changer.locked_bit, changer.unlocked_bit) if changer and description.interlocks.il_05 else ()
        self._lock_bits = bits if all(bit in codec.channels for bit in bits) else ()
        self._was_clear = False
        self._vented = VentedDetector(description, codec)
        self.supply = SupplyDetector(description.supply)
        self.evidence = [Evidence.UNKNOWN] * len(self._detectors)
        self.tool = ToolEvidence.UNCLEAR
        self.vented, self.parked = False, False
        self.looked = 0
        """How often something may have changed."""

    @property
    def levels(self) -> dict[str, int]:
        """Levels of the model that have no event: they are asked for when a command comes."""
        return {"supply_ok": int(self.supply.ok), "vented": int(self.vented), "parked": int(self.parked)}

    @property
    def conclusive(self) -> bool:
        """Whether every actuator is proven to be there or gone: enough to adopt."""
        return all(level in (Evidence.GONE, Evidence.CONFIRMED) for level in self.evidence) and (
            self._tool is None or self.tool is not ToolEvidence.UNCLEAR
        )

    @property
    def refused(self) -> int:
        """Frames that did not count because of their stamp, since the start."""
        return self._stamps.refused

    def refusals(self, at: int) -> tuple[str, ...]:
        """What was refused lately, in words; a part of the notices."""
        return self._stamps.notices(at)

    def accepts(self, frame: Frame, now: int) -> bool:
        """Whether a frame that is here at ``now`` counts, by its stamp; one that does not is told, no more."""
        passes = self._stamps.passes(frame.at, now)
        self.looked += not passes
        return passes

    def frame(self, frame: Frame) -> list[Event]:
        """The events of one frame that was accepted: what is lost before what is gone before what is confirmed,
        then by the sequence.
        """
        judged = self._rules.judge(frame)
        events: list[Event] = []
        if judged.rebooted:
            self.readings.forget()
            events = self._sample(frame.at)
        self.readings.take(judged.frame)
        for channel in judged.doubted:
            self.readings.forget(channel)
        return events + self._sample(frame.at)

    def advance(self, at: int) -> list[Event]:
        """The events of readings that turned stale; call it at :meth:`deadline`."""
        self.readings.idle()
        return self._sample(at)

    def deadline(self, at: int) -> int | None:
        """µs of the next change without any frame."""
        due = (self.readings.deadline(at), self._rules.deadline(at), self._stamps.deadline(at))
        return min((time for time in due if time is not None), default=None)

    def notices(self, at: int, *, held: bool) -> tuple[str, ...]:
        """What is wrong with the readings at ``at`` µs, in words.

        A link that is down, and an actuator of a held part without evidence, are told elsewhere.
        """
        said = [*self.refusals(at), *self._rules.notices(at)]
        if not self.readings.link_up(at):
            return tuple(said)
        unknown = self._unknown()
        told = {channel for name in unknown for channel in self._channels[name]} if held else set()
        lacking = [name for name in self._wanted if self.readings.get(name, at) is None]
        if missing := [name for name in lacking if name not in told]:
            said.append(f"No valid reading of {', '.join(missing)}.")
        if not held and (anew := [name for name in unknown if not self._channels[name] & set(lacking)]):
            said.append(f"Read again, and not judged yet: {', '.join(map(display_name, anew))}.")
        return tuple(said)

    def noticed(self, at: int, *, held: bool) -> bool:
        """Whether the notices are others than at the last call."""
        before, self._noticed = self._noticed, self.notices(at, held=held)
        return self._noticed != before

    def _unknown(self) -> list[str]:
        """Actuators without evidence."""
        pairs = zip(self._channels, self.evidence, strict=True)
        return [name for name, level in pairs if level is Evidence.UNKNOWN]

    def _sample(self, at: int) -> list[Event]:
        self.looked += 1
        self.supply.sample(self.readings, at)
        tool = self._tool.sample(self.readings, at) if self._tool else self.tool
        self._was_clear = self._was_clear or tool is not ToolEvidence.UNCLEAR
        too_early = self._was_clear and tool is ToolEvidence.UNCLEAR and self._lock_is_read(at)
        events: list[tuple[int, Event]] = []
        for index, detector in enumerate(self._detectors):
            level = detector.sample(self.readings, at)
            if level is Evidence.CONFIRMED and too_early:
                # what follows a confirmation needs the lock (IL-05): after silence it is proven a little later
                level = self.evidence[index]
            if level is not self.evidence[index]:
                self.evidence[index] = level
                event = Event(f"{_EVIDENCE_CHANNELS[level]}[{index}]", {f"evidence[{index}]": int(level)})
                events.append((_RANK.index(level), event))
        said = [event for _, event in sorted(events, key=lambda each: each[0])]
        if tool is not self.tool:
            self.tool = tool
            said.append(Event(f"tool_is[{int(tool)}]", {"tool": int(tool)}))
        self.vented = self._vented.sample(self.readings, self.evidence, at)
        self.parked = self._is_parked(at)
        return said

    def _lock_is_read(self, at: int) -> bool:
        """Whether there are fresh readings of what IL-05 asks."""
        return bool(self._lock_bits) and all(
            self.readings.get(bit, at) is not None for bit in self._lock_bits
        )

    def _is_parked(self, at: int) -> bool:
        """IL-02: in its stand, or there is none; without a fresh reading, neither."""
        if self._stand is None:
            return False
        in_stand, present = (self.readings.get(bit, at) for bit in self._stand)
        return in_stand is not None and (bool(in_stand) or present is False)
