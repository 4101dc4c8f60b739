"""How a case ends: the state of the tool, and what has led to it."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.virtual import Switching

GRIPPED = EndEffectorState.GRIPPED


class CaseEnd(NamedTuple):
    """The state of the tool at the end of a case, before the faults are removed.

    Attributes:
        state: name of the state of the end-effector; empty: its program does not run.
        active: active outputs of the grip.
        moved: the switchings, such as ``cylinder on``.
    """

    state: str
    active: tuple[str, ...]
    moved: tuple[str, ...]

    @classmethod
    def of(
        cls, description: Description, state: str, every: Iterable[Switching], moved: Iterable[Switching]
    ) -> CaseEnd:
        """Return the state from the switchings since the start and since the beginning of the case."""
        active = {each.name: each.active for each in every}
        return cls(
            state,
            tuple(name for name in description.sequence if active.get(name)),
            tuple(map(str, moved)),
        )

    def __str__(self) -> str:
        return f"{self.state or 'not running'}; active: {', '.join(self.active) or 'none'}"


class Outcome(StrEnum):
    """The state of the tool when all movements have ended."""

    AT_REST = "at rest"
    """At rest: no command was begun."""
    REFUSED = "refused"
    """At rest: the last command was refused with a reason."""
    SUCCESS = "gripped"
    FAILED = "declared failure"
    """At rest: the grip failed and was unwound."""
    CANCELLED = "cancelled"
    RELEASED = "dropped on command"
    UNWOUND = "unwound by the last will"
    HELD = "held with alarm"
    """GRIP_ERROR, latched: every output stays."""
    STILL_THERE = "release error"
    """RELEASE_ERROR, latched: not every actuator is proven to be gone."""
    UNFINISHED = "not at rest in its time"


class Story:
    """Follows the commands and deaths of a case, to name its outcome.

    Attributes:
        refused: the times of the refused commands, µs.
    """

    def __init__(self) -> None:
        self._last = Outcome.AT_REST
        self.refused: list[int] = []

    def commanded(self, name: str, at: int, *, accepted: bool) -> None:
        """Process a command at ``at`` µs, and its answer."""
        begun = {"grip": Outcome.FAILED, "cancel": Outcome.CANCELLED, "drop": Outcome.RELEASED}
        if accepted:
            self._last = begun.get(name, self._last)
        else:
            self.refused.append(at)
            self._last = Outcome.REFUSED if self._last is Outcome.AT_REST else self._last

    def gripped(self) -> None:
        """Process the success of a grip."""
        self._last = Outcome.AT_REST if self._last is Outcome.FAILED else self._last

    def hal_dies(self, *, held: bool) -> None:
        """Process a death of the program; ``held``: while a part is held."""
        if held or self._last not in (Outcome.AT_REST, Outcome.REFUSED):
            self._last = Outcome.UNWOUND

    def outcome(self, state: EndEffectorState) -> Outcome:
        """Return the outcome of a tool that has come to rest in this state."""
        latched = {
            GRIPPED: Outcome.SUCCESS,
            EndEffectorState.GRIP_ERROR: Outcome.HELD,
            EndEffectorState.RELEASE_ERROR: Outcome.STILL_THERE,
        }
        return latched.get(state, self._last)
