"""How far a story may be believed: until the tool would have moved an output that the recorded one did not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, Evidence, display_name

_AT_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)


@dataclass(frozen=True, slots=True)
class ApartSpan:
    """From ``since`` on the recorded readings answer other outputs than those of the other controller.

    Attributes:
        since: µs.
        until: µs, when both tools were at rest with the same outputs; None: to the end.
        why: which outputs, a sentence.
    """

    since: int
    until: int | None
    why: str

    def overlaps(self, since: int, until: int | None) -> bool:
        """Whether any part of it lies in that time."""
        return (until is None or self.since < until) and (self.until is None or self.until > since)


class OutputLevels:
    """Levels of the outputs of a tool, by line, from the statuses of its programs.

    Args:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self._description = description
        self._lines = [part.line for _, part in description.ordered]
        self._blowing = [description.blow_off_lines.get(name) for name in description.sequence]
        self.names = {part.line: display_name(name) for name, part in description.ordered}
        self.names |= {
            line: f"Blow-off of {display_name(name)}" for name, line in description.blow_off_lines.items()
        }
        if description.tool_changer is not None:
            self.names[description.tool_changer.line] = "Tool changer"

    def of(self, statuses: Mapping[str, Status | None]) -> dict[str, bool]:
        """By line; only what the known statuses say.

        Args:
            statuses: the latest one of each program.
        """
        levels: dict[str, bool] = {}
        grip, change, changer = (
            statuses.get("grip"),
            statuses.get("tool_change"),
            self._description.tool_changer,
        )
        if grip is not None:
            levels |= dict(zip(self._lines, grip.outputs, strict=True))
            levels |= {line: index in grip.blowing for index, line in enumerate(self._blowing) if line}
        if change is not None and changer is not None:
            levels[changer.line] = change.unlock_output
        return levels


def apart(recorded: Mapping[str, bool], other: Mapping[str, bool], names: Mapping[str, str]) -> str:
    """Which outputs differ, a phrase; empty: none does."""
    found = [
        f"{names.get(line, line)} is {_word(other.get(line, False))} here and was "
        f"{_word(recorded.get(line, False))} in the recorded run"
        for line in sorted(recorded.keys() | other.keys(), key=list(names).index)
        if recorded.get(line, False) is not other.get(line, False)
    ]
    return "; ".join(found)


def at_rest(status: Status) -> bool:
    """Whether nothing is engaged, held or left in the sensors: a tool in this state has no past that matters."""
    return (
        status.ee in _AT_REST
        and not any(status.outputs)
        and not status.blowing
        and all(level is Evidence.GONE for level in status.evidence)
    )


def _word(level: bool) -> str:
    return "active" if level else "inactive"
