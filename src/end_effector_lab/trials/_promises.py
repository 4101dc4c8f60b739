"""Rules 12 and 13 of the `Judge`: a fault has its effects, and a command succeeds if nothing is wrong."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.control import Answer, Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.virtual import VirtualTool

from ._effects import REST, Effects

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
