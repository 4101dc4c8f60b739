"""The allowed outcomes of a cell, from the description and the documented rules alone; nothing here was observed.

Rule 1: A fault changes what the sensor of its place shows: whether a new activation is confirmed, whether a
    confirmed state stays, whether a deactivated actuator is gone. `_sensor` defines this for each fault. A silent
    or unreadable link proves nothing about any actuator.
Rule 2: A grip succeeds if each step can be confirmed and no earlier one is lost. It ends if a step is not confirmed
    in its attempts, a part is lost, or an interlock refuses an activation: then the engaged actuators are released.
Rule 3: After an unwinding or a release the tool is at rest if all engaged actuators are proven gone, else in
    RELEASE_ERROR.
Rule 4: A held part stays held: a loss is a GRIP_ERROR with unchanged outputs; missing readings, and a tool that is
    not locked or absent, are alarms.
Rule 5: A cancel is accepted only in a grip, a drop only while a part is held, an error is latched, or an actuator
    is not proven gone at rest; other commands are then refused. Right after the first activation, before its line
    may be deactivated (IL-10), the last reading may still prove that nothing is there.
Rule 6: The death of the program has the declared ending; the restarted program adopts the state. The death of the
    line arbiter moves nothing.
Rule 7: A grip is refused while a sensor wrongly shows a part, the link is down, the supply pressure is too low, the
    tool is not proven to be locked and present, or the emergency stop is open.
Rule 8: An output on a bus moves when its device has acknowledged it. If the bus is silent or damaged, or the line
    arbiter dies, it may stay unchanged and is then held, with an alarm. A device that releases when it receives
    nothing (`on_link_loss`) may have done so.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from end_effector_hal.codecs import carrier_of, codec_of, is_polled, shows_noise
from end_effector_hal.description import Channel, Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import named
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import SETTLE_US, display_name
from end_effector_hal.wires.inputs import input_lines, pulls_of
from end_effector_lab.testbench.physics import Supply, Valve, physics_of

from ._cells import BOTH, NOTHING, Cell, Outcome
from ._script import GRIP, HELD, RELEASE, REST

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
SILENCING = {"silent-after", "babble-after"}
DAMAGING = {
    "noise", "flips", "bursts", "lost-bytes", "doubled-bytes", "late-answers", "no-answers", "twice-answers",
    "wrong-answers",
}  # fmt: skip
LYING = {"shows", "frozen-after", "swapped", *DAMAGING}
"""Faults under which a sensor reports a wrong state."""


@dataclass(frozen=True)
class ExpectedOutcome:
    """The allowed results of a cell.

    Attributes:
        outcomes: the allowed outcomes at the end.
        alarm: whether an alarm or a reason must have been reported.
        why: the rules from which they follow.
    """

    outcomes: frozenset[Outcome]
    alarm: bool
    why: str


def expected(description: Description, cell: Cell) -> ExpectedOutcome:
    """Return the allowed outcomes of a cell."""
    return _Rules(description, cell).expected()


def expected_view(description: Description, cell: Cell) -> str:
    """Return in words the possible readings of the sensors, by rule 1."""
    words = {
        NO: "is not confirmed", LOST: "is lost", UNKNOWN: "proves nothing",
    }  # fmt: skip
    said = []
    for name, view in _Rules(description, cell).views.items():
        found = sorted({words[each] for each in view.confirms | view.keeps if each != YES})
        found += ["is not proven gone"] if view.goes != _YES else []
        if found:
            said.append(f"{display_name(name)} {' or '.join(found)}")
    return "; ".join(said) or "no sensor of a grip is affected"


def lets_go(description: Description, cell: Cell) -> bool:
    """Return whether a device may release a part because it receives nothing (rule 8)."""
    outputs = [each for bus in description.buses.values() for each in bus.values()]
    hears_nothing = cell.command in ("kill arbiter", BOTH) or cell.name in SILENCING | DAMAGING
    return hears_nothing and any(each.on_link_loss == "release" and each.keep_alive_ms for each in outputs)


def is_loose(description: Description, cell: Cell) -> bool:
    """Return whether the sensors of the tool changer show that the tool is not locked, or absent (IL-05)."""
    changer, carried = description.tool_changer, carrier_of(description).channels
    if changer is None or not description.interlocks.il_05:
        return False
    if cell.name == "no-tool":
        return changer.present_bit in carried
    return (cell.name, cell.number) in (("locked-shows", 0.0), ("unlocked-shows", 1.0))


class _Rules:
    def __init__(self, description: Description, cell: Cell) -> None:
        self._description, self._cell = description, cell
        self._phase, self._engaged = cell.moment.phase, cell.moment.engaged
        self._sequence = description.sequence
        self.views = {name: self._sensor(name) for name in self._sequence}

    def expected(self) -> ExpectedOutcome:
        """Return the allowed outcomes by the phase and the command."""
        outcomes, why = self._outcomes()
        if self._is_late:
            outcomes, why = outcomes | self._not_acknowledged(), f"{why}, rule 8"
        latched = {Outcome.HELD, Outcome.STILL_THERE, Outcome.FAILED, Outcome.REFUSED}
        blind = self._phase == HELD and (self._is_blind() or self._is_frozen() or self._is_loose)
        return ExpectedOutcome(frozenset(outcomes), outcomes <= latched or (blind and self._goes_on), why)

    @property
    def _is_loose(self) -> bool:
        """Whether a part is held while the tool is not proven to be locked, which causes an alarm."""
        return is_loose(self._description, self._cell) and self._cell.command != "drop"

    @property
    def _goes_on(self) -> bool:
        """Whether the program keeps running."""
        return self._cell.command not in ("kill hal", BOTH)

    @property
    def _is_late(self) -> bool:
        """Whether outputs of the grip are on a bus and writes may not arrive."""
        if not self._description.buses:
            return False
        command, at_rest = self._cell.command, self._phase == REST
        if self._cell.name in {*SILENCING, *DAMAGING, "reboot-after"}:
            return not at_rest or command in (NOTHING, BOTH)
        return not at_rest and command in ("kill arbiter", BOTH)

    def _not_acknowledged(self) -> set[Outcome]:
        """Return the outcomes when a bus device does not acknowledge an output, by rule 8."""
        found = {Outcome.HELD, Outcome.STILL_THERE}
        if self._phase == REST and self._cell.command == BOTH:  # what cannot be read may hold something
            return found
        if self._phase in (REST, GRIP):  # what was measured before is on its way
            found |= {Outcome.FAILED, Outcome.SUCCESS}
        if self._cell.command == BOTH:  # the last will did not arrive: what is gripped is adopted
            found |= {Outcome.SUCCESS}
        if lets_go(self._description, self._cell):
            found |= {Outcome.AT_REST, Outcome.UNWOUND, Outcome.FAILED, Outcome.RELEASED}
        return found

    def _is_blind(self) -> bool:
        """Return whether an actuator no longer has evidence."""
        return any(view.keeps == {UNKNOWN} for view in self.views.values())

    def _is_frozen(self) -> bool:
        """Return whether a frozen sensor is detected, because its readings lack the usual noise."""
        part = self._description.actuators.get(self._cell.place)
        watched = (
            part is not None and part.frozen_s is not None and shows_noise(carrier_of(self._description))
        )
        return self._cell.name == "frozen-after" and watched and self._cell.command != "drop"

    def _outcomes(self) -> tuple[set[Outcome], str]:
        command = self._cell.command
        if self._phase == REST:
            if command == NOTHING:
                return self._from_rest()
            if command == "kill arbiter":
                return {Outcome.AT_REST, Outcome.REFUSED}, "nothing moves"
            if command == "drop" and self._refusals():
                homed = {Outcome.RELEASED, Outcome.STILL_THERE}
                return {Outcome.AT_REST, Outcome.REFUSED} | homed, "rule 5, what is not proven gone"
            return {Outcome.AT_REST, Outcome.REFUSED}, "nothing is begun"
        if not self._goes_on:
            return self._dies()
        if self._phase == GRIP:
            return self._cancelled() if command == "cancel" else self._grips()
        if self._phase == HELD:
            return self._dropped(self._sequence) if command == "drop" else (self._holds(), "rule 4")
        return self._dropped(self._sequence)

    def _from_rest(self) -> tuple[set[Outcome], str]:
        refusals = self._refusals()
        if refusals == {YES}:
            return {Outcome.REFUSED}, "rule 7"
        found, why = self._grips()
        return (found | {Outcome.REFUSED}, why) if refusals else (found, why)

    def _grips(self) -> tuple[set[Outcome], str]:
        """Return the outcomes of a grip from the current step on."""
        done = self._engaged[:-1] if self._phase == GRIP else ()
        todo = self._sequence[len(done) :]
        found: set[Outcome] = set()
        refused = self._activation_refused() if len(todo) > 1 or self._phase == REST else set()
        if refused == {YES} and self._phase == GRIP and len(todo) == 2:
            refused = {YES, NO}  # the last activation may come before the next frame
        keeps: Can = frozenset().union(*(self.views[name].keeps for name in (*done, *todo)))
        may = all(YES in self.views[name].confirms for name in todo) and refused != {YES}
        if may and (YES in keeps or not keeps - {YES}):
            found |= self._holds()
        if may and keeps - {YES}:  # it may be lost before the last one is confirmed, or after
            found |= self._holds() | self._unwound(self._sequence, Outcome.FAILED)
        for number, name in enumerate(todo):
            if NO in self.views[name].confirms:
                found |= self._unwound((*done, *todo[: number + 1]), Outcome.FAILED)
            if self.views[name].confirms == {NO}:
                break
        if refused:
            found |= self._unwound(self._sequence, Outcome.FAILED)
        return found, "rules 1 to 3"

    def _cancelled(self) -> tuple[set[Outcome], str]:
        if any(self._description.endings_of(name).gripping.cancel != "release" for name in self._engaged):
            return {Outcome.HELD, Outcome.CANCELLED}, "rule 5, declared otherwise"
        found = self._unwound(self._engaged, Outcome.CANCELLED)
        if len(self._engaged) == 1 and self._cell.moment.since < SETTLE_US:
            found |= {Outcome.CANCELLED}
        return found, "rule 5"

    def _dropped(self, names: Iterable[str]) -> tuple[set[Outcome], str]:
        found = self._unwound(names, Outcome.RELEASED)
        if self._cell.command == "kill arbiter":
            found |= {Outcome.RELEASED, Outcome.STILL_THERE}
        if self._phase == RELEASE and not self._engaged:
            found |= {Outcome.RELEASED}  # what is proven already needs no proof
        return found, "rule 3"

    def _holds(self) -> set[Outcome]:
        keeps: Can = frozenset().union(*(view.keeps for view in self.views.values()))
        every = [view.keeps for view in self.views.values()]
        found = {Outcome.SUCCESS} if not any(each == {LOST} for each in every) else set()
        return found | ({Outcome.HELD} if LOST in keeps else set())

    def _unwound(self, names: Iterable[str], proven: Outcome) -> set[Outcome]:
        names = list(names)
        every = [self.views[name].goes for name in names]
        found = {proven} if all(YES in each for each in every) else set()
        if self._cell.name in (*LYING, "invalid"):  # also what was not engaged may be shown as still there
            every += [view.goes for name, view in self.views.items() if name not in names]
        return found | ({Outcome.STILL_THERE} if any(each != {YES} for each in every) else set())

    def _dies(self) -> tuple[set[Outcome], str]:
        """Return the outcomes when the program dies, by rule 6."""
        if self._phase == RELEASE:
            return {Outcome.UNWOUND, Outcome.RELEASED}, "rule 6: the release is completed"
        of = [self._description.endings_of(name) for name in self._engaged]
        endings = [(each.held if self._phase == HELD else each.gripping).process_death for each in of]
        if all(each == "release" for each in endings):
            return {Outcome.UNWOUND}, "rule 6"
        if any(each == "release" for each in endings) or self._phase == GRIP:
            return {Outcome.HELD, Outcome.SUCCESS, Outcome.UNWOUND}, "rule 6, declared otherwise"
        seen = [view.keeps if view.keeps != {YES} else view.confirms for view in self.views.values()]
        found = {Outcome.SUCCESS} if all(YES in each or UNKNOWN not in each for each in seen) else set()
        if any(each != {YES} for each in seen):
            found |= {Outcome.HELD}
        return found, "rule 6: it is adopted"

    # Rule 1

    def _sensor(self, name: str) -> SensorView:
        cell, part = self._cell, self._description.actuators[name]
        if cell.name in SILENCING and self._is_of_link(name):
            return ANYTHING if self._keeps_its_level(name) else self._blind(name)
        if cell.name in DAMAGING:
            frames = [link.frame for link in self._description.links.values() if link.frame]
            rare = (cell.number or 0.0) <= 0.001 and all(frame.checked for frame in frames)
            return SensorView(_YES, frozenset({YES, UNKNOWN}), _YES) if rare else ANYTHING
        if cell.name == "supply":
            return SensorView(frozenset({YES, NO}), frozenset({YES, LOST}), _YES)
        if cell.place != name:
            swapped = cell.name == "swapped" and self._after(cell.place) == name
            return ANYTHING if swapped or self._unproven_by_alarm(name) else NORMAL
        engaged = name in self._engaged
        match cell.name:
            case "never-confirms":
                return SensorView(_YES if engaged and self._phase == GRIP else frozenset({NO}))
            case "fails-once" | "fails":
                number, pending = cell.number or 1.0, engaged and self._phase == GRIP
                # an activation that comes while the line arbiter is dead costs an attempt more
                more = cell.command == "kill arbiter" and self._phase == GRIP
                if number >= part.attempts and not pending:
                    return SensorView(frozenset({NO}))
                return SensorView(
                    frozenset({YES, NO}) if number + more >= part.attempts and not pending else _YES
                )
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
        part, supply = self._description.actuators[name], self._description.supply
        if self._cell.name == "leak-grows":
            return SensorView(frozenset({YES, NO}), frozenset({LOST, YES}), _YES)
        device = physics_of(part.kind).on_air(Valve(0), Supply(supply.nominal_kpa), 0)
        device.leak(self._cell.number or 4.0)
        device.settle(True)
        left, limits = abs(device.pressure_kpa or 0.0), kind_of(part).limits(part, supply)
        return SensorView(
            _YES if left > limits.get("confirmed_kpa", 0.0) else frozenset({NO}),
            _YES if left > limits.get("lost_kpa", 0.0) else frozenset({LOST}),
        )

    def _keeps_its_level(self, name: str) -> bool:
        """Return whether input lines of the board confirm the actuator: a line that falls silent keeps its level."""
        return any(channel.digital for channel in self._proofs(name))

    def _proofs(self, name: str) -> list[Channel]:
        """Return the declared channels that confirm the actuator."""
        part, channels = self._description.actuators[name], self._description.channels
        return [channels[each] for each in kind_of(part).channel_names(part) if each in channels]

    def _has_switch(self, name: str) -> bool:
        """Return whether a switch confirms the actuator, too."""
        part = self._description.actuators[name]
        bits = [key.key for key in kind_of(part).channels if key.carries is Kind.BIT]
        return any(named(getattr(part, key)) for key in bits)

    def _is_of_link(self, name: str) -> bool:
        """Return whether the sensor of the actuator uses the silent link."""
        if not self._cell.place or len(self._description.named_links) < 2:
            return True
        return any(channel.link == self._cell.place for channel in self._proofs(name))

    def _pulled(self, name: str) -> bool | None:
        """Return the level that an input with a broken wire shows because of its pull; None: no such input confirms
        the actuator.
        """
        match self._proofs(name):
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
        channel = self._description.channels.get(self._cell.place)
        return bool(channel and channel.alarm and any(name in each.unproven for each in channel.alarm))

    # Rule 7

    def _refusals(self) -> set[str]:
        """Return whether a grip is refused at its beginning: yes, or perhaps; empty if it is accepted."""
        cell, description = self._cell, self._description
        if cell.name == "invalid":
            return set() if self._pulled(cell.place) is False else {YES}
        if cell.name in SILENCING:
            return {YES, NO} if any(map(self._keeps_its_level, self._sequence)) else {YES}
        if cell.name == "supply":
            low = self._is_air_read() and (cell.number or 0.0) < description.supply.refuse_kpa
            return {YES} if low else set()
        if cell.name in LYING or cell.name == "alarm" or cell.name == "reboot-after":
            return {YES, NO}
        return self._activation_refused()

    def _is_air_read(self) -> bool:
        """Return whether IL-06 has a sensor and is switched on."""
        supply = self._description.supply.channel in carrier_of(self._description).channels
        return supply and self._description.interlocks.il_06

    def _activation_refused(self) -> set[str]:
        """Return whether the line arbiter refuses activations of a grip."""
        cell, description = self._cell, self._description
        changer = description.tool_changer
        if cell.name == "estop-open" and description.e_stop:
            return {YES}
        if changer and description.interlocks.il_05:
            if is_loose(description, cell):
                return {YES}
            if cell.name in ("locked-shows", "unlocked-shows", "swapped", *DAMAGING):
                return {NO, YES} if cell.name in DAMAGING and (cell.number or 0) > 0.001 else set()
        if cell.name in SILENCING or cell.name == "alarm":
            return {NO, YES}
        return set()
