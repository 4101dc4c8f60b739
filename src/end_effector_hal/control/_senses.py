"""All detectors of a tool: frames and time in, events of the model out."""

from __future__ import annotations

from end_effector_hal.automata import Event
from end_effector_hal.description import Description, VacuumActuator
from end_effector_hal.wires.codecs import Codec
from end_effector_hal.wires.frame import Frame

from ._constants import channels_of, used_channels
from ._cylinder_detector import CylinderDetector
from ._levels import Evidence, ToolEvidence
from ._link_rules import LinkRules
from ._readings import Readings
from ._supply_detector import SupplyDetector
from ._tool_detector import ToolDetector
from ._vacuum_detector import VacuumDetector

_EVIDENCE_CHANNELS = {
    Evidence.UNKNOWN: "stale",
    Evidence.GONE: "gone",
    Evidence.PARTIAL: "partial",
    Evidence.CONFIRMED: "confirmed",
}
_TOOL_CHANNELS = {
    ToolEvidence.UNCLEAR: "tool_unclear",
    ToolEvidence.LOCKED: "tool_locked",
    ToolEvidence.UNLOCKED: "tool_unlocked",
}


class Senses:
    """Stands between samples and events: a level each, and an event at each change of one."""

    def __init__(self, description: Description, codec: Codec) -> None:
        self.readings = Readings(description.link, codec)
        self._rules = LinkRules(description, codec, self.readings.stale_us)
        self._wanted = tuple(name for name in used_channels(description) if name in codec.channels)
        self._channels = tuple(channels_of(part) for _, part in description.ordered)
        self._noticed: tuple[str, ...] = ()
        self._detectors = tuple(
            VacuumDetector(part)
            if isinstance(part, VacuumActuator)
            else CylinderDetector(part, description.supply)
            for _, part in description.ordered
        )
        changer = description.tool_changer
        self._tool = ToolDetector(changer) if changer else None
        self.supply = SupplyDetector(description.supply)
        self.evidence = [Evidence.UNKNOWN] * len(self._detectors)
        self.tool = ToolEvidence.UNCLEAR

    @property
    def settled(self) -> bool:
        """Whether every actuator is proven to be there or gone: enough to adopt."""
        return all(level in (Evidence.GONE, Evidence.CONFIRMED) for level in self.evidence) and (
            self._tool is None or self.tool is not ToolEvidence.UNCLEAR
        )

    def frame(self, frame: Frame) -> list[Event]:
        """The events of one frame, in the order of the sequence."""
        judged = self._rules.judge(frame)
        events: list[Event] = []
        if judged.rebooted:
            self.readings.forget()
            events = self._sample(frame.at)
        self.readings.take(judged.frame)
        for channel in judged.frozen:
            self.readings.forget(channel)
        return events + self._sample(frame.at)

    def advance(self, at: int) -> list[Event]:
        """The events of readings that turned stale; call it at :meth:`deadline`."""
        self.readings.idle()
        return self._sample(at)

    def deadline(self, at: int) -> int | None:
        """µs of the next change without any frame."""
        due = (self.readings.deadline(at), self._rules.deadline(at))
        return min((time for time in due if time is not None), default=None)

    def notices(self, at: int, *, held: bool) -> tuple[str, ...]:
        """What is wrong with the readings at ``at`` µs, in words.

        A link that is down, and an actuator of a held part without evidence, are told elsewhere.
        """
        told = self._unknown() if held else set()
        lacking = [name for name in self._wanted if name not in told and self.readings.get(name, at) is None]
        said = self._rules.notices(at)
        if lacking and self.readings.link_up(at):
            said = (*said, f"No valid reading of {', '.join(lacking)}.")
        return said

    def noticed(self, at: int, *, held: bool) -> bool:
        """Whether the notices are others than at the last call."""
        before, self._noticed = self._noticed, self.notices(at, held=held)
        return self._noticed != before

    def _unknown(self) -> set[str]:
        """Channels of the actuators without evidence."""
        pairs = zip(self._channels, self.evidence, strict=True)
        return {name for names, level in pairs if level is Evidence.UNKNOWN for name in names}

    def _sample(self, at: int) -> list[Event]:
        self.supply.sample(self.readings, at)
        events = []
        for index, detector in enumerate(self._detectors):
            level = detector.sample(self.readings, at)
            if level is not self.evidence[index]:
                self.evidence[index] = level
                events.append(
                    Event(f"{_EVIDENCE_CHANNELS[level]}[{index}]", {f"evidence[{index}]": int(level)})
                )
        tool = self._tool.sample(self.readings, at) if self._tool else self.tool
        if tool is not self.tool:
            self.tool = tool
            events.append(Event(_TOOL_CHANNELS[tool], {"tool": int(tool)}))
        return events
