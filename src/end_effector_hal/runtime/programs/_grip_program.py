"""The gripping program, with maintenance mode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from end_effector_hal.control import Answer, EventKind, Status
from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, LineRefusedError, WireError
from end_effector_hal.runtime.outputs import GripOutputs, Maintenance, OutputMapping
from end_effector_hal.runtime.stream import MAINTENANCE_WORDS, TOO_LATE, ProgramCommand
from end_effector_hal.vocabulary import Alarm, Evidence, display_name

from ._adoption import Adoption
from ._latest_status import LatestStatus
from ._program import Program


def drive(adoption: Adoption, maintenance: Maintenance, line: str, at: int, *, active: bool) -> Answer:
    """Write a line at ``at`` µs, under the lease; return whether that succeeded."""
    if refused := adoption.controller.refuse_maintenance(active=active):
        return Answer(False, refused)
    try:
        adoption.outputs.drive(line, active, maintenance.will_with(line, active))
    except WireError as error:
        if active and not isinstance(error, LineRefusedError):
            # perhaps it was executed: then the lease ends it
            maintenance.drove(line, active, at)
        return Answer(False, str(error), decided=not isinstance(error, ArbiterError))
    maintenance.drove(line, active, at)
    return Answer(True)


def proof(
    latest: LatestStatus, description: Description, name: str, timeout_s: float | None, *, active: bool
) -> Answer:
    """Wait until the sensors prove the wanted level. The default time limit is the actuator's ``timeout_s`` or
    ``release_s``.
    """
    actuator, index = description.actuators[name], description.sequence.index(name)
    limit_s = timeout_s or (actuator.timeout_s if active else actuator.release_s)
    wanted = Evidence.CONFIRMED if active else Evidence.GONE
    if latest.wait(lambda status: status.evidence[index] == wanted, limit_s):
        proven = "active" if active else "inactive"
        return Answer(True, f"{display_name(name)} is {proven}, proven by its sensor.")
    shown = latest.status.evidence[index].name
    left = f" It stays active for {description.maintenance.lease_s:g} s at most." if active else ""
    what = f"its line is written, but its sensor does not prove it within {limit_s:g} s (it says {shown})"
    return Answer(False, f"{display_name(name)}: {what}.{left}")


class GripProgram(Program):
    """Executes the gripping automata; deactivates the lines of maintenance when its lease expires (IL-12)."""

    NAME: ClassVar = "grip"

    def set_actuator(self, name: str, active: bool, timeout_s: float | None = None) -> Answer:
        """Drive one actuator in maintenance (IL-12); success requires sensor evidence.

        Args:
            name: name of the actuator.
            active: the level that its output gets.
            timeout_s: longest wait for the evidence; default: the time that the actuator has in a grip or a release.
        """
        answer = self._drive(name, None, active=active)
        proven = answer.accepted and proof(self._latest, self._description, name, timeout_s, active=active)
        return proven or answer

    def _drive(self, name: str, until_us: int | None, *, active: bool) -> Answer:
        """Write the line of an actuator in maintenance; refuse if ``until_us`` is over."""
        line = self._description.actuators[name].line

        def question() -> tuple[Answer, list[Status]]:
            at = self._clock()
            if until_us is not None and at > until_us:
                return Answer(False, TOO_LATE), []
            if obstacle := self._obstacle("activate" if active else "deactivate"):
                return Answer(False, obstacle, decided=not self._adoption.lost), []
            answer = drive(self._adoption, self._maintenance, line, at, active=active)
            return answer, [self._adoption.controller.status()] if answer.accepted else []

        return self._ask(question, waits=True)

    def _asked(self, asked: ProgramCommand) -> Answer:
        """Execute a client's command; a maintenance command is answered when the line is written.

        Waiting for its sensor would delay the commands of other clients.
        """
        if asked.command not in MAINTENANCE_WORDS:
            return super()._asked(asked)
        if asked.actuator not in self._description.actuators:
            there = ", ".join(self._description.sequence)
            return Answer(False, f"There is no actuator called {asked.actuator!r}; there are {there}.")
        return self._drive(asked.actuator, asked.until_us, active=asked.command == "activate")

    def _mapping(self) -> OutputMapping:
        self._maintenance = Maintenance(self._description)
        return GripOutputs(self._description, self._maintenance)

    def _keep_faults(self, faults: Mapping[str, str]) -> list[Status]:
        """Keep the latched faults; a new stop cancels a running grip."""
        before, adoption = self._stopped, self._adoption
        statuses = super()._keep_faults(faults)
        gripping = adoption.begun and adoption.outputs.mapping.gripping(adoption.controller.status())
        if before or not self._stopped or not gripping:
            return statuses
        return [*statuses, *adoption.controller.command("cancel", self._clock())[1]]

    def _due(self) -> int | None:
        due, ends_at = super()._due(), self._maintenance.ends_at
        return due if ends_at is None else ends_at if due is None else min(due, ends_at)

    def _on_time(self, at: int) -> list[Status]:
        if lines := self._maintenance.over(at):
            self._adoption.outputs.let_go(lines, at)
        return super()._on_time(at)

    def _obstacle(self, name: str) -> str:
        if name == "grip" and self._maintenance.active:
            return f"IL-12: a grip is refused during maintenance. {self._maintenance.notice}"
        return super()._obstacle(name)

    def _unrest(self) -> str:
        return super()._unrest() or self._maintenance.notice

    def _notices(self) -> tuple[Alarm, ...]:
        notices, active = super()._notices(), self._maintenance.notice
        return (*notices, Alarm("maintenance.active", "", {"text": active})) if active else notices

    def _completed(self, status: Status, notices: tuple[Alarm, ...]) -> Status:
        completed, adoption = super()._completed(status, notices), self._adoption
        written = adoption.outputs
        if completed.blowing and written.refused:  # inactive: no air
            air, names = self._description.blow_off_lines, self._description.sequence
            blown = tuple(each for each in completed.blowing if air[names[each]] in written.activated)
            events = tuple(
                event
                for event in completed.events
                if event.kind is not EventKind.BLOWN_OFF or event.actuator in blown
            )
            completed = replace(completed, blowing=blown, events=events)
        if adoption.lost:  # as last known; what was never known is in doubt active
            known = written.known
            pairs = zip(self._description.ordered, completed.outputs, strict=True)
            outputs = tuple(known.get(part.line, level or not adoption.begun) for (_, part), level in pairs)
            held = completed.held if adoption.begun else self._held
            completed = replace(completed, outputs=outputs, held=held)
        if not self._maintenance.active:
            return completed
        lines = self._maintenance.lines
        parts = zip(self._description.ordered, completed.outputs, strict=True)
        outputs = tuple(output or part.line in lines for (_, part), output in parts)
        return replace(completed, outputs=outputs, deadline=self._maintenance.ends_at, maintenance=True)
