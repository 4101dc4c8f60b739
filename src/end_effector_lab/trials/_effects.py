"""The effects of a fault on the evidence of each actuator, computed from the description alone, not from observations;
and rules 12 and 13 of the `Judge`: a fault has its effects, and a command succeeds if nothing is wrong.

A fault changes what the sensor of its place shows: whether a new activation is confirmed, whether a confirmed state
stays, whether a deactivated actuator is gone. A silent or unreadable link proves nothing about any actuator.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from end_effector_hal.codecs import carrier_of, codec_of, is_polled, shows_noise
from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Channel, Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import named
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import Command, EndEffectorState, display_name
from end_effector_hal.wires.inputs import input_lines, pulls_of
from end_effector_lab.testbench import chosen_models, plain_number
from end_effector_lab.testbench.physics import Supply, Valve, physics_of
from end_effector_lab.virtual import VirtualTool

REST, GRIP, HELD, RELEASE = "rest", "grip", "held", "release"
PHASES = (REST, GRIP, HELD, RELEASE)
YES, NO, LOST, UNKNOWN = "yes", "no", "lost", "unknown"
Can = frozenset[str]
_YES = frozenset({YES})


class SensorView(NamedTuple):
    """The possible readings of an actuator's sensor under a fault; several if the rules leave it open.

    Attributes:
        confirms: whether a new activation is confirmed: ``yes``, ``no`` (in all its attempts).
        keeps: whether a confirmed state stays: ``yes``, ``lost``, ``unknown``.
        goes: whether a deactivated actuator is proven to be gone: ``yes``, ``no``, ``unknown``.
    """

    confirms: Can = _YES
    keeps: Can = _YES
    goes: Can = _YES


NORMAL = SensorView()
BLIND = SensorView(frozenset({NO}), frozenset({UNKNOWN}), frozenset({UNKNOWN}))
ANYTHING = SensorView(frozenset({YES, NO}), frozenset({YES, LOST, UNKNOWN}), frozenset({YES, NO, UNKNOWN}))
LET_GO = SensorView(frozenset({NO}), frozenset({LOST}), _YES)
"""The view of a sensor that never detects a part."""
SILENCING = {"silent-after", "babble-after", "closed-after"}
DAMAGING = {
    "noise", "flips", "bursts", "lost-bytes", "doubled-bytes", "late-answers", "no-answers", "twice-answers",
    "wrong-answers", "cut-answers",
}  # fmt: skip
STRANGE = {"foreign-write-after", "other-device-after"}
"""Faults by another client or device on a commanded bus."""
LYING = {"shows", "frozen-after", "swapped", *DAMAGING, *STRANGE}
"""Faults under which a sensor reports a wrong state."""
PHYSICAL = {
    "nominal", "never-confirms", "fails-once", "fails", "stuck-release", "sticks", "leak", "leak-grows", "lost-after",
    "no-part",
}  # fmt: skip
"""Faults of an actuator and its part; the sensors show what is real."""


class FaultWords(NamedTuple):
    """A fault in the words of the testbench.

    Attributes:
        text: such as ``leak:top_vacuum:4``.
    """

    text: str

    @property
    def name(self) -> str:
        """The name of the fault alone."""
        return self.text.partition(":")[0]

    @property
    def place(self) -> str:
        """The faulty part; empty: the whole tool."""
        parts = self.text.split(":")
        return parts[1] if len(parts) > 1 and parts[1][:1].isalpha() else ""

    @property
    def number(self) -> float | None:
        """The number of the fault; None if it has none."""
        return plain_number(self.text.split(":")[-1])


class Effects:
    """The effects of one fault that begins at some moment.

    Args:
        fault: in the words of the testbench.
        phase: what the tool does then, of `PHASES`.
        engaged: the actuators whose outputs are active then, in the order of the sequence.

    Attributes:
        views: by actuator, what its sensor can show.
        is_harmless: whether a grip must succeed, and a part stay held, as without the fault.
        is_loose: whether the sensors of the tool changer show that the tool is not locked, or absent (IL-05).
        refuses_grip: whether no grip may begin.
        needs_alarm: whether an alarm must be on while a part is held: its evidence is missing, or the tool is loose.
    """

    def __init__(
        self, description: Description, fault: str, phase: str, engaged: tuple[str, ...], part: str = ""
    ) -> None:
        self._description, self.fault = description.for_part(part), FaultWords(fault)
        self._phase, self._engaged = phase, engaged
        self._sequence = description.sequence
        self.views = {name: self._sensor(name) for name in self._sequence}
        views, unaffected = self.views.values(), all(view == NORMAL for view in self.views.values())
        self.is_harmless = unaffected and self.fault.name in PHYSICAL
        self.is_loose = self._shows_loose()
        self.refuses_grip = self._refuses_grip()
        used = zip(views, description.uses(part), strict=True)
        blind = any(view.keeps == {UNKNOWN} for view, uses in used if uses)
        self.needs_alarm = blind or self.is_loose or self._is_watched_frozen()

    @property
    def words(self) -> str:
        """The effects as a phrase."""
        words = {NO: "is not confirmed", LOST: "is lost", UNKNOWN: "proves nothing"}
        said = []
        for name, view in self.views.items():
            found = sorted({words[each] for each in view.confirms | view.keeps if each != YES})
            found += ["is not proven gone"] if view.goes != _YES else []
            if found:
                said.append(f"{display_name(name)} {' or '.join(found)}")
        return "; ".join(said) or "no sensor of a grip is affected"

    def _sensor(self, name: str) -> SensorView:
        fault, actuator = self.fault, self._description.actuators[name]
        if fault.name in SILENCING and self._is_of_link(name):
            return ANYTHING if self._keeps_its_level(name) else self._blind(name)
        if fault.name in STRANGE:
            return ANYTHING
        if fault.name in DAMAGING:
            frames = [link.frame for link in self._description.links.values() if link.frame]
            rare = (fault.number or 0.0) <= 0.001 and all(frame.checked for frame in frames)
            return SensorView(_YES, frozenset({YES, UNKNOWN}), _YES) if rare else ANYTHING
        if fault.name == "supply":
            return SensorView(frozenset({YES, NO}), frozenset({YES, LOST}), _YES)
        if fault.place != name:
            swapped = fault.name == "swapped" and self._after(fault.place) == name
            return ANYTHING if swapped or self._unproven_by_alarm(name) else NORMAL
        engaged = name in self._engaged
        match fault.name:
            case "never-confirms":
                return SensorView(_YES if engaged and self._phase == GRIP else frozenset({NO}))
            case "fails-once" | "fails":
                pending = engaged and self._phase == GRIP
                fails = (fault.number or 1.0) >= actuator.attempts and not pending
                return SensorView(frozenset({NO}) if fails else _YES)
            case "stuck-release" if self._phase == RELEASE and not engaged:
                return NORMAL  # it was deactivated before
            case "stuck-release" | "sticks":
                sure = not self._is_blown(name) and (engaged or self._phase != RELEASE)
                return SensorView(goes=frozenset({NO}) if sure else frozenset({YES, NO}))
            case "leak" | "leak-grows":
                view = self._leaking(name)
                pending = self._phase == GRIP and name in self._engaged[-1:]
                return (
                    view._replace(confirms=frozenset({YES, NO})) if pending else view
                )  # it may be there already
            case "lost-after":
                return SensorView(frozenset({YES, NO}), frozenset({LOST}), _YES)
            case "no-part":
                pending = self._phase == GRIP and name in self._engaged[-1:]  # it may be there already
                return SensorView(frozenset({YES, NO} if pending else {NO}), frozenset({LOST}), _YES)
            case "invalid" if (pulled := self._pulled(name)) is not None:
                return SensorView(_YES, _YES, frozenset({NO})) if pulled else LET_GO
            case "invalid" if self._has_switch(name):
                return SensorView(frozenset({YES, NO}), frozenset({YES, UNKNOWN}), frozenset({YES, UNKNOWN}))
            case "invalid":
                return self._blind(name)
            case "shows" | "frozen-after" | "swapped":
                return ANYTHING
        return NORMAL

    def _blind(self, name: str) -> SensorView:
        """Return the view of an actuator without readings; an answer to an earlier request may still arrive."""
        asked = any(is_polled(codec_of(self._description, link)) for link in self._description.links)
        pending = self._phase == GRIP and name in self._engaged[-1:]
        return BLIND._replace(confirms=frozenset({YES, NO})) if asked and pending else BLIND

    def _leaking(self, name: str) -> SensorView:
        """Return the view of a leaking actuator by its final pressure."""
        actuator, supply = self._description.actuators[name], self._description.supply
        if self.fault.name == "leak-grows":
            return SensorView(frozenset({YES, NO}), frozenset({LOST, YES}), _YES)
        device = physics_of(actuator.kind).on_air(Valve(0), Supply(supply.nominal_kpa), 0)
        device.leak(self.fault.number or 4.0)
        device.settle(True)
        left, limits = abs(device.pressure_kpa or 0.0), kind_of(actuator).limits(actuator, supply)
        return SensorView(
            _YES if left > limits.get("confirmed_kpa", 0.0) else frozenset({NO}),
            _YES if left > limits.get("lost_kpa", 0.0) else frozenset({LOST}),
        )

    def _keeps_its_level(self, name: str) -> bool:
        """Return whether input lines of the board confirm the actuator: a line that falls silent keeps its level."""
        return any(channel.digital for channel in self._proofs(name))

    def _proofs(self, name: str) -> list[Channel]:
        """Return the declared channels that confirm the actuator."""
        actuator, channels = self._description.actuators[name], self._description.channels
        return [channels[each] for each in kind_of(actuator).channel_names(actuator) if each in channels]

    def _has_switch(self, name: str) -> bool:
        """Return whether a switch confirms the actuator, too."""
        actuator = self._description.actuators[name]
        bits = [key.key for key in kind_of(actuator).channels if key.carries is Kind.BIT]
        return any(named(getattr(actuator, key)) for key in bits)

    def _is_of_link(self, name: str) -> bool:
        """Return whether the sensor of the actuator uses the silent link."""
        if not self.fault.place or len(self._description.named_links) < 2:
            return True
        return any(channel.link == self.fault.place for channel in self._proofs(name))

    def _pulled(self, name: str) -> bool | None:
        """Return what an input with a broken wire shows, because of its pull or as an open input of an I/O board that
        has a model; None: no such input confirms the actuator.
        """
        match self._proofs(name):
            case [channel] if channel.modbus and channel.modbus.register_type == "discrete_input":
                models = chosen_models(None, self._description).get(channel.link or "", {})
                return channel.invert if channel.modbus.unit in models else None
            case [channel] if channel.digital:
                pulls = pulls_of(input_lines(self._description))
                return (pulls[channel.digital.line] == "up") is not channel.invert
        return None

    def _is_blown(self, name: str) -> bool:
        return name in self._description.blow_off_lines

    def _after(self, name: str) -> str:
        """Return the actuator whose sensor is exchanged with the swapped one."""
        if name not in self._sequence:
            return ""
        return self._sequence[(self._sequence.index(name) + 1) % len(self._sequence)]

    def _unproven_by_alarm(self, name: str) -> bool:
        channel = self._description.channels.get(self.fault.place)
        return bool(channel and channel.alarm and any(name in each.unproven for each in channel.alarm))

    # What must happen

    def _shows_loose(self) -> bool:
        changer, fault = self._description.tool_changer, self.fault
        if changer is None or not self._description.interlocks.il_05:
            return False
        if fault.name == "no-tool":
            return changer.present_bit in carrier_of(self._description).channels
        return (fault.name, fault.number) in (("locked-shows", 0.0), ("unlocked-shows", 1.0))

    def _refuses_grip(self) -> bool:
        fault, supply = self.fault, self._description.supply
        if fault.name == "invalid":
            return self._pulled(fault.place) is not False
        if fault.name in SILENCING:
            return not any(map(self._keeps_its_level, self._sequence))
        if fault.name == "supply":
            is_read = supply.channel in carrier_of(self._description).channels
            return (
                is_read and self._description.interlocks.il_06 and (fault.number or 0.0) < supply.refuse_kpa
            )
        return self.is_loose or (fault.name == "estop-open" and self._description.e_stop is not None)

    def _is_watched_frozen(self) -> bool:
        """Return whether a frozen sensor is detected, because its readings lack the usual noise."""
        actuator = self._description.actuators.get(self.fault.place)
        watched = (
            actuator is not None
            and actuator.frozen_s is not None
            and shows_noise(carrier_of(self._description))
        )
        return self.fault.name == "frozen-after" and watched


GRIPPED, STAND_BY, RELEASING = EndEffectorState.GRIPPED, EndEffectorState.STAND_BY, EndEffectorState.RELEASING
TOLD_US, ALARM_US, BACK_US = 600_000, 10_000_000, 1_050_000
"""Time after a fault until it prevents a grip, and until its alarm; longest absence of a line arbiter that excuses no
failure, µs.
"""
READY = {"grip": STAND_BY, "drop": GRIPPED}
"""The state in which a command must be accepted."""


class Promises:
    """The effects of the present fault, and the state that the accepted commands must reach.

    Args:
        object_to: called with a rule and a sentence.
    """

    def __init__(
        self, description: Description, tool: VirtualTool, object_to: Callable[[str, str], None]
    ) -> None:
        self._description, self._tool, self._object = description, tool, object_to
        self._goal = STAND_BY
        self._excused = False
        self._effects: Effects | None = None
        self._since = self._arbiter_gone_at = tool.at
        gripping = [description.endings_of(name).gripping for name in description.sequence]
        self._cancel_releases = all(each.cancel == "release" for each in gripping)

    def excuse(self) -> None:
        """Note an event after which any command may fail."""
        self._excused = True

    def suffers(self, scenario: str, phase: str, engaged: tuple[str, ...]) -> None:
        """Process a new scenario of the testbench; see `Effects` for the phase and the engaged actuators."""
        self._since = self._tool.at
        self._set_effects(scenario, phase, engaged)

    def _set_effects(self, scenario: str, phase: str, engaged: tuple[str, ...]) -> None:
        single = "," not in scenario
        self._effects = self._effects_of(scenario, phase, engaged) if single else None
        self._excused |= self._effects is None or not self._effects.is_harmless

    def _effects_of(self, scenario: str, phase: str, engaged: tuple[str, ...]) -> Effects:
        return Effects(self._description, scenario, phase, engaged, self._tool.statuses[-1].part)

    def commanded(self, name: str, answer: Answer) -> None:
        """Process a command and its answer."""
        if not answer.accepted:
            self._refused(name)
            return
        if name in ("grip", "drop", "cancel"):
            self._goal = GRIPPED if name == "grip" else STAND_BY
        if name in ("lock", "unlock", "arm") or (name == "cancel" and not self._cancel_releases):
            self._excused = True
        if name == "grip" and self._effects is not None:
            self._set_effects(self._effects.fault.text, REST, ())
            if (effects := self._effects_after(TOLD_US)) and effects.refuses_grip:
                self._object("effects", f"a grip was accepted with {effects.fault.text}")

    def _refused(self, name: str) -> None:
        status = self._tool.statuses[-1]
        idle = status.command == Command.NONE and len(self._tool.living) == 2
        if not self._excused and idle and READY.get(name) == status.ee == self._goal:
            self._object("success", f"a {name} was refused, and nothing is wrong")

    def hal_dies(self, *, unwinds: bool, keeps: bool) -> None:
        """Process the death of the program: ``unwinds``: all is released; ``keeps``: a held part is kept."""
        if unwinds:
            self._goal = STAND_BY
        elif self._tool.statuses[-1].ee != self._goal or not keeps:
            self._excused = True

    def arbiter_ends(self) -> None:
        """Process the end of the line arbiter."""
        releasing = self._tool.statuses[-1].ee == RELEASING
        self._excused |= releasing or self._tool.arbiters > 1 or bool(self._description.register_outputs)
        self._arbiter_gone_at = self._tool.at

    def arbiter_begins(self) -> None:
        """Process the start of the next line arbiter."""
        self._excused |= self._tool.at - self._arbiter_gone_at > BACK_US

    def activated(self, name: str) -> None:
        """Process an output of the grip that became active."""
        if (effects := self._effects_after(TOLD_US)) and effects.is_loose:
            self._object("effects", f"{name} became active with {effects.fault.text} (IL-05)")

    def at_rest(self, status: Status) -> None:
        """Judge the tool at the end."""
        effects = self._effects_after(ALARM_US)
        if status.ee == GRIPPED and effects and effects.needs_alarm and not status.alarms:
            self._object("effects", f"GRIPPED with {effects.fault.text}, without an alarm")
        if not self._excused and len(self._tool.living) == 2 and status.ee != self._goal:
            self._object("success", f"{status.ee.name} instead of {self._goal.name}, and nothing is wrong")

    def _effects_after(self, us: int) -> Effects | None:
        """Return the effects of the present fault, if it has lasted for more than ``us`` µs."""
        return self._effects if self._tool.at - self._since > us else None
