"""The evidence of the sensors at one time; a frame, or a silence, leads to a new state.

`stays` finds out whether coming frames change nothing, so that a simulation may leave them out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

from end_effector_hal.codecs import Carrier
from end_effector_hal.description import Description
from end_effector_hal.kinds import detector_of, fault_of, is_guarded, kind_of
from end_effector_hal.kinds.conditions import ConditionDetector
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.sensing._device_faults import DeviceFaults
from end_effector_hal.sensing._link_rules import LinkRules
from end_effector_hal.sensing._output_gate import OutputGate
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.sensing.detectors import ReleaseDetector, SupplyDetector, ToolDetector
from end_effector_hal.signals import NESTED, Frame, Value, clone, lengthen, streaks_of
from end_effector_hal.vocabulary import Alarm, Evidence, ToolEvidence


class SensorState:
    """The newest readings, all detectors, and their results; a state is never changed once it is shared.

    So all users that have received the same frames may share one state: the next frame creates a new one.

    Attributes:
        readings: readings of all channels.
        part: position of the part in the description whose values count; `use` changes it.
        faults: the channels that are alarms of a device.
        conditional: whether any actuator is judged by conditions.
        supply: whether a grip may start (IL-06).
        evidence: evidence of each actuator, in sequence order.
        withheld: positions in the sequence of actuators whose sensors say that they are gone, but whose devices have
            not shown yet that they have obeyed; see `OutputGate`.
        tool: evidence of the tool changer's bits.
        emptied: positions in the sequence of actuators that gripped nothing and are not confirmed.
        nothing_gripped: whether nothing is gripped, as IL-01 requires.
        in_stand: whether the tool is in its stand, or there is no tool (IL-02).
    """

    MEMORY: ClassVar = {
        "readings": NESTED,
        "_rules": NESTED,
        "_gate": NESTED,
        "_detectors": NESTED,
        "part": int,
        "_levels": tuple[Evidence, ...],
        "_tool": NESTED,
        "_release": NESTED,
        "supply": NESTED,
        "_was_clear": bool,
        "evidence": tuple[Evidence, ...],
        "withheld": tuple[int, ...],
        "tool": ToolEvidence,
        "emptied": tuple[int, ...],
        "nothing_gripped": bool,
        "in_stand": bool,
    }

    def __init__(self, description: Description, carrier: Carrier) -> None:
        self.readings = Readings(description, carrier)
        self._rules = LinkRules(description, carrier, self.readings.stale_us)
        self._gate, self._on_bus = OutputGate(description), bool(description.register_outputs)
        self._actuators = description.ordered
        self.faults = DeviceFaults(description)
        # all parts are judged all the time: what is proven of another one is known when it is asked for
        stanzas, self._uses = (
            list[tuple[int, Actuator]](),
            tuple(map(description.uses, description.part_names)),
        )
        for tool in description.per_part:
            stanzas += [
                each for each in enumerate(actuator for _, actuator in tool.ordered) if each not in stanzas
            ]
        self._actuator_of = tuple(index for index, _ in stanzas)
        self._detectors_of = tuple(
            tuple(number for number, owner in enumerate(self._actuator_of) if owner == index)
            for index in range(len(self._actuators))
        )
        self._detectors_for = tuple(
            tuple(stanzas.index(each) for each in enumerate(actuator for _, actuator in tool.ordered))
            for tool in description.per_part
        )
        self._detectors = tuple(detector_of(each, description.supply) for _, each in stanzas)
        self.conditional = any(isinstance(each, ConditionDetector) for each in self._detectors)
        self._guarded = tuple(
            (number, description.sequence[index])
            for number, index in enumerate(self._actuator_of)
            if is_guarded(self._detectors[number])
        )
        self.part = 0
        changer = description.tool_changer
        self._tool = ToolDetector(changer) if changer else None
        self._stand = (changer.stand_bit, changer.present_bit) if changer else None
        bits = frozenset[str]()
        if changer and description.interlocks.il_05:
            bits = frozenset([changer.locked_bit, changer.unlocked_bit])
        self._lock_bits = bits if bits <= carrier.channels.keys() else frozenset()
        if changer and self._lock_bits and changer.present_bit in carrier.channels:
            self._lock_bits |= {changer.present_bit}
        self._was_clear = False
        self._release = ReleaseDetector(description, carrier)
        self.supply = SupplyDetector(description.supply)
        self._levels: tuple[Evidence, ...] = (Evidence.UNKNOWN,) * len(self._detectors)
        self.evidence: tuple[Evidence, ...] = (Evidence.UNKNOWN,) * len(self._actuators)
        self.withheld: tuple[int, ...] = ()
        self.tool = ToolEvidence.UNCLEAR
        self.emptied: tuple[int, ...] = ()
        self.nothing_gripped, self.in_stand = False, False

    def take(self, frame: Frame) -> Iterator[None]:
        """Change this state to the one that a frame leads to.

        Each item stands for one change, which is made when the item is requested: one, preceded by another one if the
        device restarted.
        """
        frame, doubted, rebooted = self._rules.judge(frame)
        at = max(frame.at, self.readings.last_frame)
        if frame.inactive:
            self._gate.see(frame)
        if rebooted:
            for channel in rebooted:
                self.readings.forget(channel)
            self.readings.idle()
            self._sample(at)
            yield
        self.readings.take(frame, doubted)
        for channel in doubted:
            self.readings.forget(channel)
        self._sample(at)
        yield

    def switch(self, index: int, at: int, *, active: bool) -> None:
        """Change this state to the one after a command to an actuator, by its position in the sequence."""
        self._gate.switch(index, at, active=active)
        self._judge()

    def wait(self, at: int) -> None:
        """Change this state to the one after a silence until ``at`` µs; call this method at :meth:`deadline`."""
        self.readings.idle()
        self._sample(at)

    def deadline(self, at: int) -> int | None:
        """Return the time of the next change without a frame, after ``at``, µs; None: there is none."""
        due, ends = self.readings.deadline(at), self._rules.deadline(at)
        return due if ends is None else ends if due is None else min(due, ends)

    def mixed(self, at: int) -> frozenset[str]:
        """Return the channels of links on which two devices send; they are a part of the doubts."""
        return self._rules.mixed(at)

    def doubts(self, at: int) -> tuple[Alarm, ...]:
        """Return alarms at ``at`` µs: impossible or frozen readings, failed detectors, restarted devices."""
        said = self._rules.notices(at)
        return (*said, *self._faults()) if self._guarded else said

    def verdict(self, at: int) -> object:
        """Return a value that is equal for states with the same evidence and the same alarms."""
        judges = self.by_conditions if self.conditional else ()
        found = [(each.level, each.empty, each.broken, each.settles(at)) for _, each in judges]
        supply, proven = self.supply, (self.nothing_gripped, self.in_stand)
        return self.evidence, self.tool, supply.ok, supply.low, *proven, self.doubts(at), found

    @property
    def is_guarded(self) -> bool:
        """Whether a detector comes from a plug-in, which may count in ways that are not known here."""
        return bool(self._guarded)

    @property
    def by_conditions(self) -> tuple[tuple[int, ConditionDetector], ...]:
        """Detectors that judge by conditions, with the position of their actuator in the sequence."""
        chosen = [(i, self._detectors[number]) for i, number in enumerate(self._detectors_for[self.part])]
        return tuple([(i, each) for i, each in chosen if isinstance(each, ConditionDetector)])

    @property
    def used(self) -> tuple[bool, ...]:
        """Whether each actuator grips the part."""
        return self._uses[self.part]

    def evidence_of(self, part: int) -> tuple[Evidence, ...]:
        """Return what the newest readings prove of each actuator by the values of a part.

        It is gone only by the values of every part: whatever was held before, nothing is there. What counts as gone
        too early is neither gone nor confirmed.
        """
        levels = self._levels_for(part)
        if not (self._on_bus and (early := self._gate.withheld(levels))):
            return levels
        return tuple([Evidence.PARTIAL if i in early else level for i, level in enumerate(levels)])

    def use(self, part: int) -> None:
        """Judge by the values of a part from now on; the evidence is that of the newest readings."""
        self.part = part
        self._judge()

    def empty(self, index: int) -> str:
        """Return the kind's clause if an actuator has gripped nothing; empty: that is not proven."""
        found = any(i == index and each.empty for i, each in self.by_conditions)
        return kind_of(self._actuators[index][1]).empty if found else ""

    @property
    def confirmed(self) -> bool:
        """Whether every actuator that grips the part is proven to grip."""
        return all(
            level is Evidence.CONFIRMED for level, used in zip(self.evidence, self.used, strict=True) if used
        )

    @property
    def conclusive(self) -> bool:
        """Whether every actuator is proven to be confirmed or gone, which is enough to adopt."""
        return all(level in (Evidence.GONE, Evidence.CONFIRMED) for level in self.evidence) and (
            self._tool is None or self.tool is not ToolEvidence.UNCLEAR
        )

    def _faults(self) -> Iterator[Alarm]:
        for index, name in self._guarded:
            if fault := fault_of(self._detectors[index]):
                yield Alarm("kind.failed", name, {"what": "judged", "why": fault})

    def _sample(self, at: int) -> None:
        self.readings.look(at)
        self.supply.sample(self.readings)
        tool = self._tool.sample(self.readings, at) if self._tool else self.tool
        self._was_clear = self._was_clear or tool is not ToolEvidence.UNCLEAR
        # all channels that IL-05 needs are read, and do not prove yet that the tool is locked
        unclear, lock_bits = self._was_clear and tool is ToolEvidence.UNCLEAR, self._lock_bits
        too_early = unclear and lock_bits and lock_bits <= self.readings.fresh.keys()
        levels = []
        for detector, before in zip(self._detectors, self._levels, strict=True):
            level = detector.sample(self.readings, at)
            # what follows a confirmation needs the lock (IL-05): after silence it is proven a little later
            levels.append(before if level is Evidence.CONFIRMED and too_early else level)
        if self.faults.channels and (unproven := self.faults.unproven(self.readings, at)):
            for number, index in enumerate(self._actuator_of):
                levels[number] = Evidence.UNKNOWN if self._actuators[index][0] in unproven else levels[number]
        self._levels, self.tool = tuple(levels), tool
        self._judge()
        self.nothing_gripped = self._release.sample(self.readings, self.evidence, at)
        self.in_stand = self._stand is not None and self._is_in_stand(*self._stand)

    def _is_in_stand(self, stand_bit: str, present_bit: str) -> bool:
        """Return whether the tool is in its stand or absent (IL-02); False without a fresh reading."""
        read = self.readings.fresh.get
        in_stand = read(stand_bit)
        return in_stand is not None and (bool(in_stand) or read(present_bit) is False)

    def _levels_for(self, part: int) -> tuple[Evidence, ...]:
        """Return the levels of a part's detectors, gone only where all detectors of the actuator say so."""
        if len(self._detectors_for) == 1:
            return self._levels
        found = [self._levels[number] for number in self._detectors_for[part]]
        for index, level in enumerate(found):
            if level is Evidence.GONE:
                others = {self._levels[number] for number in self._detectors_of[index]} - {Evidence.GONE}
                found[index] = (
                    Evidence.UNKNOWN if Evidence.UNKNOWN in others else Evidence.PARTIAL if others else level
                )
        return tuple(found)

    def _judge(self) -> None:
        """Set the evidence of the part from the newest levels of the detectors."""
        one = len(self._detectors_for) == 1 and not self._on_bus
        self.evidence = self._levels if one else self.evidence_of(self.part)
        if self._on_bus:
            self.withheld = self._gate.withheld(self._levels_for(self.part))
        if self.conditional:
            found = [i for i, each in self.by_conditions if each.empty]
            self.emptied = tuple([i for i in found if self.evidence[i] is not Evidence.CONFIRMED])


def stays(
    state: SensorState,
    newest: Frame,
    corners: Sequence[Mapping[str, Value]],
    first: int,
    period: int,
    samples: int,
) -> bool:
    """Return whether coming frames will change nothing that the newest one has shown; the state does not change.

    Two conditions are checked. First, a frame of each corner proves the same as the newest frame, and starts or stops
    no count of a detector, so that their order does not matter. Second, after this number of samples and this time
    nothing else is proven; with constant values no detector returns to an earlier state.

    Args:
        state: the state after the newest frame.
        newest: that frame.
        corners: values of a frame; the coming values lie between them.
        first: time of the first frame, µs.
        period: time from one frame to the next, µs.
        samples: number of frames.
    """
    if state.is_guarded:  # a plug-in's detector may count in its own way
        return False
    last, state = first + (samples - 1) * period, clone(state)
    now, streaks = state.verdict(newest.at), streaks_of(state)
    counts = [streak.samples > 0 for streak in streaks]

    def ends_alike(at: int, values: Mapping[str, Value]) -> bool:
        for _ in state.take(Frame(at, None, None, values)):
            if state.verdict(at) != now or [streak.samples > 0 for streak in streaks] != counts:
                return False
        return True

    values: Mapping[str, Value] = newest.values
    for values in corners:
        if not ends_alike(first, values):
            return False
    lengthen(streaks, samples)
    return ends_alike(last, values)
