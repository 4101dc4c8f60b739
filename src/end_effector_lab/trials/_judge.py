"""The rules that must always hold, judged by the description and by the real state of the simulated devices.

The rules share no code with the controller or the line arbiter, and were not derived from observed behaviour.

Rule 1 (held): from GRIPPED, or a latched GRIP_ERROR, until an accepted drop no output of the grip becomes inactive
    (IL-09); one whose release was owed before, and reported as owed, may.
Rule 2 (order): released outputs become inactive in the release order, each one when the previous device is gone or
    its time is over; when a step is retried, only the output of the last active step becomes inactive. A board that
    restarts switches all its outputs at once.
Rule 3 (activation): an output of the grip becomes active only in an accepted, running grip, after all earlier
    steps, within its attempts and with the pause between them, with the tool really locked and a link that can
    report it (IL-05, IL-11), and not while the emergency stop is open. A write may be under way when the grip ends.
Rule 4 (unlock): the unlock output is active only after an accepted unlock, with every vacuum gone for a while and
    the tool not away from its stand, never together with an output of the grip (IL-01, IL-02, IL-05), and not
    longer than its longest time while the line arbiter lives (IL-03).
Rule 5 (switching): a line keeps its level for its least time (IL-10); only an arbiter that ends may cut a pulse
    short.
Rule 6 (evidence): GRIPPED holds only while every device really grips; a lift is allowed only while a link can
    report it and the tool is locked and present; GRIP_ERROR becomes GRIPPED only by an accepted resume; a release
    ends in STAND_BY only when every device is gone. Changes younger than the time of a reading may not be known yet.
Rule 7 (refusals): a grip is refused while a device still grips, the supply pressure is too low, the link is silent,
    or the tool is not locked, or absent (IL-05 to IL-07), a resume while the link is silent or the tool is not locked
    or absent; a refusal has a reason.
Rule 8 (unwound): the actuators that the dead program had engaged are deactivated as declared, while the
    arbiter lives and its buses answer; a device that has restarted waits for a Drop, which activates it.
Rule 9 (told): at rest, lines and state agree, or the evidence shows that a device waits for a Drop, or an alarm that a
    release is owed; a latched error, a loss and missing sensor data have been reported.
Rule 10 (latched): faults latched by the line arbiter, and the sensor fault of the tool changer, stay until a reset,
    even if the program or the arbiter dies in between, or the power is lost.
Rule 11 (late): a command is accepted only while a line arbiter lives that can execute it, and after its result no
    output of the grip becomes inactive because of it; a device on a bus may receive it later.
Rule 12 (effects): a single fault has its effects (`Effects`): it prevents a grip or the activation of an output, or it
    causes an alarm while a part is held.
Rule 13 (success): a command succeeds if nothing is wrong. Then there is no fault or a harmless one, and no process has
    died but the program, or a line arbiter that is back within a second.

While a sensor lies, the truth cannot be known: rules 3, 6 and 7 then ignore the real state.
"""

from __future__ import annotations

from end_effector_hal.arbiter import HAL
from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import (
    LEASE_US,
    SETTLE_US,
    Command,
    EndEffectorState,
    Evidence,
    to_us,
)
from end_effector_lab.virtual import Edge, Switching, VirtualTool, switchings

from ._effects import GRIP, HELD, RELEASE, REST, Promises
from ._reality import FRAMES_US, JudgedArbiter, Reality

GRIPPED, GRIP_ERROR = EndEffectorState.GRIPPED, EndEffectorState.GRIP_ERROR
RELEASE_ERROR, STAND_BY = EndEffectorState.RELEASE_ERROR, EndEffectorState.STAND_BY
GRIPPING, RELEASING = EndEffectorState.GRIPPING, EndEffectorState.RELEASING
MARGIN_US = 1_000_000
ANSWERED_US = 200_000
"""Time in which a device on a bus that is read obeys a command, µs: one lost answer, and another attempt."""
UNDER_WAY_US = 5_000
"""Longest way of a write over a bus, µs: it may arrive after the end of the grip."""
NEAR_US = 5_000
"""Time by which a pause may appear too short, µs: actions that are due at the same time are executed one after the
other.
"""


class Judge:
    """Judges a tool; `look` is called at each instant at which something happens.

    Attributes:
        objections: rule and sentence, in the order in which they were found; each rule once.
        let_go: whether a device released a held part because it received nothing, as declared (`on_link_loss`).
    """

    def __init__(self, description: Description, tool: VirtualTool) -> None:
        self._description, self._tool, self._begun = description, tool, tool.at
        self._sequence = description.sequence
        self._pulsed_coils = {
            coil
            for line, each in description.opposites.items()
            if each.pulse_s is not None
            for coil in (line, each.line)
        }
        self._line = {name: actuator.line for name, actuator in description.ordered}
        changer = description.tool_changer
        self._changer = changer.line if changer else ""
        limited = changer is not None and not changer.latching
        self._longest_unlock_us = (
            round(changer.unlock_max_s * 1e6) + SETTLE_US if changer and limited else 1 << 62
        )
        self._unlocks_on_bus = self._changer in description.register_outputs
        self._longest_unlock_us += ANSWERED_US if self._unlocks_on_bus else 0
        self.objections: dict[str, str] = {}
        self.let_go = False
        self._active = dict.fromkeys(self._sequence, False)
        self._changed_at = {edge.line: edge.at for edge in tool.edges}
        self._reality = Reality(description, tool)
        self._seen = len(tool.edges), len(tool.statuses)
        self._held = False
        self._resumed = False
        self._grip_runs, self._grip_over_at = False, 0
        self._attempts = dict.fromkeys(self._sequence, 0)
        self._unlock_accepted = False
        self._unlocked_since: int | None = None
        self._unwound_by: int | None = None
        self._disturbed = False
        self._arbiter = JudgedArbiter(tool, self._reality)
        self._grip_since = tool.at
        self._ended: dict[str, int] = {}
        self._released_at = tool.at - 2 * SETTLE_US
        self._let_go: dict[str, int] = {}
        self._promises = Promises(description, tool, self._object)

    @property
    def _gripping(self) -> Description:
        """The tool as it grips the present part."""
        return self._description.for_part(self._tool.statuses[-1].part)

    @property
    def _used(self) -> tuple[str, ...]:
        """The actuators that grip the present part, in the order of a grip."""
        uses = self._description.uses(self._tool.statuses[-1].part)
        return tuple(name for name, used in zip(self._sequence, uses, strict=True) if used)

    # What happens to the tool

    def suffers(self, scenario: str) -> None:
        """Process a new scenario of the testbench."""
        self._reality.suffers(scenario)
        ee = self._tool.statuses[-1].ee
        phase = HELD if self._held else GRIP if self._grip_runs else RELEASE if ee == RELEASING else REST
        engaged = tuple(name for name in self._sequence if self._active[name])
        self._promises.suffers(scenario, phase, engaged)

    def commanded(self, name: str, answer: Answer, at: int) -> None:
        """Process a command that was given at ``at`` µs, and its answer."""
        if name == "reset":
            self._arbiter.reset(answer)
        self._promises.commanded(name, answer)
        if not answer.accepted:
            if not answer.reason:
                self._object("refusals", f"{name} was refused without a reason")
            return
        if name in ("drop", "cancel") and not self._arbiter.lives:
            self._object("late", f"a {name} was accepted while there is no line arbiter")
        if name == "drop":
            self._held = False
        elif name == "resume":
            self._resumed = True
            for why in self._reality.against_a_lift():
                self._object("refusals", f"a resume was accepted while {why}", at)
        elif name == "unlock":
            self._unlock_accepted = True
        elif name == "grip":
            self._grip_runs, self._unwound_by, self._grip_since = True, None, at
            self._attempts = dict.fromkeys(self._sequence, 0)
            self._let_go, self._ended = {}, {}
            for why in self._reality.against_a_grip():
                self._object("refusals", f"a grip was accepted while {why}", at)

    def hal_dies(self) -> None:
        """Process the coming death or end of the program."""
        tool = self._tool
        if HAL in tool.living:
            self._grip_runs, self._let_go = False, {}
            ee = tool.statuses[-1].ee
            unwinds = not self._held and (
                ee == GRIPPING or (ee == RELEASING and self._arbiter.has_heard_of(self._released_at))
            )
            if unwinds:
                self._expect_unwinding()
            self._promises.hal_dies(
                unwinds=unwinds and all(map(self._is_unwound, self._sequence)),
                keeps=not any(map(self._may_be_let_go, self._sequence)),
            )

    def _look_at_arbiter(self) -> None:
        """Process the end or start of the arbiter, which measures the unlock and executes last wills."""
        gone, came = self._arbiter.look()
        if gone:
            self._promises.arbiter_ends()
            self._unlocked_since = None
            self._unwound_by = None if self._unwound_by is None else 1 << 62
        if not came:
            return
        self._promises.arbiter_begins()
        if self._changer and self._tool.levels.get(self._changer):
            self._unlocked_since = self._tool.at
        if self._unwound_by is not None:
            self._expect_unwinding()
            self._unwound_by += LEASE_US

    def disturbed(self) -> None:
        """Process a disturbed store: the arbiter's data may be lost. In doubt it holds, and no last will is required
        of it.
        """
        self._disturbed, self._unwound_by = True, None
        self._promises.excuse()
        self._arbiter.forget()

    def power_lost(self) -> None:
        """Process a loss of power: the program has died and all lines are inactive; valves with two coils keep their
        position; the journal keeps the latched faults.
        """
        edges, statuses = self._tool.edges, self._tool.statuses
        self._seen = len(edges), len(statuses)
        self._active = {name: self._stays_without_power(name) for name in self._active}
        self._changed_at = dict.fromkeys(self._changed_at, self._tool.at - SETTLE_US)
        self._held = self._grip_runs = self._unlock_accepted = False
        self._promises.excuse()
        self._let_go = {}
        self._unlocked_since = self._unwound_by = None

    def _stays_without_power(self, name: str) -> bool:
        """Return whether a valve with two coils is, or is moving, where its first coil moves it: it stays there."""
        actuator = self._description.actuators[name]
        bus = actuator.modbus
        pulsed = bus is not None and (bus.pulse_s is not None or bus.opposite is not None)
        kept = pulsed and actuator.on_power_loss in ("hold", "keep")
        if actuator.line not in self._description.opposites and not kept:
            return False
        valve = self._tool.bench.devices[name].valve
        return valve.is_open == valve.settled

    # What is seen of it

    def look(self) -> bool:
        """Judge the new events; return False, as `VirtualTool.run_until` expects."""
        tool, (edges, statuses) = self._tool, self._seen
        self._reality.look()
        self._look_at_arbiter()
        if len(tool.edges) > edges:
            self._moved(tool.edges[edges:])
        if len(tool.statuses) > statuses:
            for number in range(statuses, len(tool.statuses)):
                self._told(tool.statuses[number - 1] if number else None, tool.statuses[number])
        self._seen = len(tool.edges), len(tool.statuses)
        if HAL in tool.living:
            self._is_held(tool.statuses[-1])
        if self._unlocked_since is not None and self._unlocks_on_bus and not self._reality.is_read:
            self._unlocked_since = tool.at  # a bus that is lost cannot end it
        since = self._unlocked_since
        if self._arbiter.lives and not self._disturbed:  # rule 10
            for what in self._arbiter.unlatched():
                self._object("latched", what)
        if since is not None and tool.at - since > self._longest_unlock_us:
            self._object("unlock", "the unlock output is active for longer than its longest time (IL-03)")
        if self._unwound_by is not None and self._is_cut_off:
            self._expect_unwinding()
        if self._unwound_by is not None and tool.at > self._unwound_by:
            self._unwound()
        return False

    def at_rest(self, *, still: bool) -> None:
        """Judge the tool at the end: ``still`` if it came to rest, else the time was over."""
        status, active = self._tool.status, [name for name in self._sequence if self._active[name]]
        if HAL not in self._tool.living:
            return
        if self._unwound_by is not None and self._arbiter.lives and not self._is_cut_off:
            self._unwound()  # the program that began again could not before that was over
        if not still:
            self._object("told", f"not at rest in its time: {status.ee.name}, {status.command.name}")
        elif status.ee == STAND_BY and not self._cannot_deactivate(status):
            if left := [name for name in active if not self._is_known_to_wait(name, status)]:
                self._object("told", f"STAND_BY with {', '.join(left)} active")
        elif status.ee == GRIPPED:
            self._at_rest_held(status, active)
        elif status.ee in (GRIP_ERROR, RELEASE_ERROR) and not (status.reason or status.alarms):
            self._object("told", f"{status.ee.name} without a reason")
        self._promises.at_rest(status)

    def _cannot_deactivate(self, status: Status) -> bool:
        """Return whether no arbiter is present to deactivate outputs, which was reported; a sensor may wrongly show
        that nothing is held.
        """
        return not self._arbiter.lives and bool(status.alarms)

    def _waits_for_a_drop(self, name: str) -> bool:
        return self._reality.waits_for_a_drop(name, self._changed_at.get(self._line[name], self._begun))

    def _is_known_to_wait(self, name: str, status: Status) -> bool:
        """Return whether a release is owed, or a device waits for a Drop and the tool shows that it is not gone."""
        if self._is_owed(name, status):
            return True
        evidence = status.evidence[self._sequence.index(name)]
        return self._waits_for_a_drop(name) and evidence is not Evidence.GONE

    def _is_owed(self, name: str, status: Status) -> bool:
        """Return whether a status shows an output as inactive, and reports that its device has not acknowledged it."""
        owed = any(
            each.id == "arbiter.fault" and each.about == f"output {self._line[name]}"
            for each in status.alarms
        )
        return owed and not status.outputs[self._sequence.index(name)]

    @property
    def _is_cut_off(self) -> bool:
        """Whether a bus with outputs was silent a moment ago: its releases come later."""
        return bool(self._description.register_outputs) and not self._reality.is_read

    def _at_rest_held(self, status: Status, active: list[str]) -> None:
        used = self._used
        missing = [name for name in used if name not in active and not self._reality.lets_go(name)]
        if missing:
            self._object("told", f"GRIPPED with {', '.join(missing)} inactive")
        if more := [name for name in active if name not in used]:
            self._object("told", f"GRIPPED with {', '.join(more)} active, which do not grip this part")
        self._is_held(status)
        if self._reality.lasts("silent") and not status.alarms:
            self._object("told", "GRIPPED with a silent link, without an alarm")

    # Rules 1 to 5

    def _moved(self, edges: list[Edge]) -> None:
        for edge in edges:
            stood = edge.at - self._changed_at.get(edge.line, edge.at - SETTLE_US)
            # of a register the pause is between two commands
            on_bus = edge.line in self._description.register_outputs
            cut = not edge.level and edge.at == self._arbiter.until and edge.line in self._pulsed_coils
            if stood < SETTLE_US and not (on_bus or cut):
                self._object("switching", f"{edge.line} was switched after {stood / 1000:g} ms (IL-10)")
            self._changed_at[edge.line] = edge.at
            if edge.line == self._changer:
                self._unlock(edge)
            for each in switchings(self._description, [edge]):
                if self._active[each.name] != each.active:
                    (self._activated if each.active else self._deactivated)(each)
                    self._active[each.name] = each.active

    def _unlock(self, edge: Edge) -> None:
        self._unlocked_since = edge.at if edge.level else None
        if not edge.level:
            return
        if not self._unlock_accepted:
            self._object("unlock", "the unlock output became active, and no unlock was accepted (IL-11)")
        self._unlock_accepted = False
        if self._description.interlocks.il_01 and any(self._active.values()):
            self._object("unlock", "the unlock output became active with an output of the grip (IL-01)")
        for why in self._reality.against_an_unlock():
            self._object("unlock", f"the unlock output became active, and {why}")

    def _activated(self, each: Switching) -> None:
        name, used = each.name, self._used
        before = used[: used.index(name)] if name in used else ()
        if name not in used:
            self._object("activation", f"{name} became active, which does not grip this part")
        # a write that is on its way over a bus when the grip ends cannot be taken back
        on_bus = self._line[name] in self._description.register_outputs
        if not self._grip_runs and not (on_bus and each.at - self._grip_over_at <= UNDER_WAY_US):
            self._object("activation", f"{name} became active without a grip (IL-11)")
        self._attempts[name] += 1
        allowed = self._gripping.actuators[name].attempts
        if self._attempts[name] > allowed:
            self._object("activation", f"{name} was activated more often than {allowed} times")
        self._let_go.pop(name, None)
        if (ended := self._ended.get(name)) is not None and self._arbiter.has_lived_since(self._grip_since):
            pause_us = each.at - ended
            if pause_us < to_us(self._gripping.actuators[name].reset_s) - NEAR_US:
                self._object("activation", f"{name} was tried again after {pause_us / 1e6:.3f} s")
        for other in before:
            if not self._active[other]:
                if not self._reality.is_overruled(other):
                    self._object("activation", f"{name} became active before {other}")
            elif self._reality.is_known and self._reality.lasts(f"gone {other}"):
                self._object("activation", f"{name} became active, and {other} does not grip")
        if self._changer and self._tool.levels.get(self._changer):
            self._object("activation", f"{name} became active with the unlock output (IL-05)")
        if self._description.interlocks.il_05 and self._reality.is_known and self._reality.lasts("unlocked"):
            self._object("activation", f"{name} became active, and the tool is not locked (IL-05)")
        if self._description.interlocks.il_05 and self._changer and self._reality.lasts("silent"):
            self._object(
                "activation", f"{name} became active, and no sensor proves that the tool is locked (IL-05)"
            )
        self._promises.activated(name)
        if self._reality.lasts("estop"):
            self._object("activation", f"{name} became active with an open emergency stop (IL-13)")

    def _deactivated(self, each: Switching) -> None:
        name, order = each.name, self._description.releasing
        # at once after a release was told it has asked for it, and IL-10 has delayed it: that is no attempt's end
        # nor is the reset of a device that its activation begins with
        commanded = self._tool.statuses[-1].outputs[self._sequence.index(name)]
        if each.at - self._released_at > SETTLE_US and not commanded:
            self._ended[name] = each.at
        if self._held and self._reality.lets_go(name):
            self.let_go = True
        elif self._held and not (self._may_be_let_go(name) or self._is_owed(name, self._tool.statuses[-1])):
            self._object("held", f"{name} was deactivated while the part is held (IL-09)")
        if HAL in self._tool.living and not self._may_be_let_go(name) and self._is_late(each):
            self._object("late", f"{name} was deactivated when every command had its result")
        if self._unwinds():
            self._paused(each, order[: order.index(name)])
            self._let_go[name] = each.at
        if name == [other for other in self._sequence if self._active[other]][-1]:
            return  # the last one: also when it is tried again
        if self._reality.restarted(name, each.at) or self._reality.is_overruled(name):
            return
        for other in order[: order.index(name)]:
            if self._active[other] and self._is_unwound(other) and not self._is_overdue(other, each.at):
                self._object("order", f"{name} was deactivated before {other}")

    def _is_overdue(self, name: str, at: int) -> bool:
        """Return whether a release waits for a silent bus and its time is over: the next one waits no longer."""
        actuator = self._gripping.actuators[name]
        on_bus = actuator.line in self._description.register_outputs
        return on_bus and self._is_cut_off and at - self._released_at >= to_us(actuator.release_s) - NEAR_US

    def _is_late(self, each: Switching) -> bool:
        """Return whether no command was active at that time, and the program has not just started."""
        on_bus = self._gripping.actuators[each.name].line in self._description.register_outputs
        if on_bus or self._tool.statuses[-1].ee == EndEffectorState.OFF:
            return False
        for status in reversed(self._tool.statuses):
            if status.command != Command.NONE:
                return False
            if status.at < each.at:
                break
        return True

    def _unwinds(self) -> bool:
        """Return whether a deactivation now belongs to a release, not to a failed attempt."""
        tool = self._tool
        return HAL not in tool.living or tool.statuses[-1].ee in (RELEASING, RELEASE_ERROR, STAND_BY)

    def _paused(self, each: Switching, before: tuple[str, ...]) -> None:
        """Check that the previous device had its release time, or no longer grips."""
        let_go = [other for other in before if other in self._let_go]
        if not let_go or not self._arbiter.has_lived_since(self._grip_since) or not self._reality.is_known:
            return
        other = let_go[-1]
        waited_us = each.at - self._let_go[other]
        if waited_us < to_us(
            self._gripping.actuators[other].release_s
        ) - NEAR_US and self._reality.surely_grips(other):
            self._object(
                "order",
                f"{each.name} was deactivated {waited_us / 1e6:.3f} s after {other}, which still grips",
            )

    def _unwound(self) -> None:
        """Check the outputs after the time of a last will."""
        self._unwound_by = None
        active = [name for name in self._sequence if self._active[name] and not self._waits_for_a_drop(name)]
        if left := [name for name in active if self._is_unwound(name)]:
            self._object("unwound", f"{', '.join(left)} stays active after the death of the program")

    def _may_be_let_go(self, name: str) -> bool:
        """Return whether any ending is declared that releases the actuator (only without IL-09), or its device
        receives nothing.
        """
        endings = self._description.endings_of(name)
        held = endings.held
        return "release" in (
            held.lost,
            held.sigterm,
            held.process_death,
            endings.power_up,
        ) or self._reality.lets_go(name)

    def _is_unwound(self, name: str) -> bool:
        """Return whether every ending before GRIPPED releases the actuator."""
        found = self._description.endings_of(name).gripping
        every = (found.cancel, found.timeout, found.abort, found.sigterm, found.process_death)
        return all(each == "release" for each in every)

    def _expect_unwinding(self) -> None:
        if self._disturbed or not self._arbiter.lives:
            self._unwound_by = None if self._disturbed else 1 << 62
            return
        actuators = self._description.actuators.values()
        blown = sum(each.whole_ms for each in self._description.blow_offs.values()) * 1000
        longest = round(sum(actuator.release_s for actuator in actuators) * 1e6) + blown
        self._unwound_by = self._tool.at + longest + MARGIN_US

    # Rules 6 and 7

    def _told(self, before: Status | None, status: Status) -> None:
        ee, tool = status.ee, self._tool
        latched = ee == GRIPPED or (ee == GRIP_ERROR and status.command == Command.NONE)
        if ee in (GRIPPED, GRIP_ERROR, RELEASE_ERROR, RELEASING, STAND_BY) and status.command != Command.GRIP:
            self._grip_over_at = status.at if self._grip_runs else self._grip_over_at
            self._grip_runs = False
        if ee == RELEASING:  # the attempts of a grip end with it
            self._released_at, self._ended = status.at, {}
            self._attempts = dict.fromkeys(self._sequence, 0)
        if ee == GRIPPED:
            if before is not None and before.ee == GRIP_ERROR and not self._resumed:
                self._object("evidence", "GRIP_ERROR has become GRIPPED, and no resume was accepted")
            self._resumed = False
        if latched and not self._held:
            self._held = True
            if ee == GRIPPED and status.at == tool.at and self._reality.is_known:
                for name in self._used:
                    # what was lost since was not read yet
                    if self._reality.lasts(f"gone {name}", FRAMES_US) and not self._reality.closes(name):
                        self._object("evidence", f"GRIPPED, and {name} does not grip")
        released = before is not None and before.ee == RELEASING and ee == STAND_BY
        if released and status.at == tool.at and self._reality.is_known:
            for name in self._sequence:
                if self._reality.lasts(f"left {name}", FRAMES_US):  # so young a vacuum was not read yet
                    self._object("evidence", f"a release has ended in STAND_BY, and {name} is not gone")

    def _is_held(self, status: Status) -> None:
        """Check that GRIPPED, and the permission to lift, are still justified."""
        if status.ee != GRIPPED:
            return
        if status.lift_allowed and (why := next(self._reality.against_a_lift(), "")):
            self._object("evidence", f"{why}, and a lift is allowed")
        if not self._reality.is_read:
            return
        for name in self._used:
            if self._reality.lasts(f"gone {name}"):
                self._object(
                    "evidence", f"{name} has not gripped for a while, and the end-effector is GRIPPED"
                )

    def _object(self, rule: str, what: str, at: int | None = None) -> None:
        seconds = ((self._tool.at if at is None else at) - self._begun) / 1e6
        self.objections.setdefault(rule, f"{rule}: {what}, at {seconds:.3f} s")
