"""The timeline: measured values as samples, and states as lanes."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import SwitchMeaning, kind_of
from end_effector_hal.vocabulary import display_name

from ._cards import is_releasing
from ._curves import Curve

KEPT_US = 180_000_000
FRESH_US = 1_000_000
"""Time for which a value is still drawn while frames of other links arrive."""
MOST_SAMPLES = 20_000
MOST_CHANGES = 4_000
SWITCH = "switch "
"""Prefix of a channel in the name of a lane, since an actuator may have the same name."""


class TimeLine:
    """The samples and changes of the last three minutes, and those since a given count.

    Args:
        curves: the curves that are drawn.
        switches: channels of bits, with the meaning of each.
    """

    def __init__(
        self, description: Description, curves: Sequence[Curve], switches: Mapping[str, SwitchMeaning]
    ) -> None:
        self.curves, self._switches = curves, switches
        self._ordered = description.ordered
        self._changer = description.tool_changer is not None
        self._samples: deque[list[Any]] = deque(maxlen=MOST_SAMPLES)
        self._changes: deque[dict[str, Any]] = deque(maxlen=MOST_CHANGES)
        self._last: dict[str, str] = {}
        self._values: dict[str, tuple[int, Any]] = {}
        self.sampled = self.changed = 0
        """Counts of all samples and changes."""

    def frame(self, at: int, values: Mapping[str, Any]) -> None:
        """Add one frame of the sensors."""
        row: list[Any] = [at]
        self._values |= {name: (at, value) for name, value in values.items()}
        for curve in self.curves:
            came_at, value = self._values.get(curve.channel, (at, None))
            value = None if at - came_at > FRESH_US else value  # one of several links may be silent
            row.append(None if value is None else curve.shown(value))
        self._samples.append(row)
        self.sampled += 1
        bits = [name for name in self._switches if name in values]
        self._note(at, {f"{SWITCH}{name}": self._words(name, values[name]) for name in bits})
        while self._samples and self._samples[0][0] < at - KEPT_US:
            self._samples.popleft()

    def status(self, status: Status) -> None:
        """Add one status of the tool."""
        words = {"": status.ee.label}
        for index, (name, actuator) in enumerate(self._ordered):
            state = kind_of(actuator).states(status.actuators[index])
            words[name] = "RELEASING" if is_releasing(status, index) else state.label
        if self._changer:
            words["tool changer"] = status.changer.name
        self._note(status.at, words)

    def gap(self, at: int) -> None:
        """Mark all lanes as unknown from this time on."""
        if self._last:
            self._note(at, dict.fromkeys(self._last, ""))

    def since(self, sampled: int, changed: int) -> dict[str, Any]:
        """Return the samples and changes beyond these counts."""
        new = min(len(self._samples), self.sampled - sampled)
        fresh = min(len(self._changes), self.changed - changed)
        return {
            "samples": [self._samples[index] for index in range(-new, 0)],
            "changes": [self._changes[index] for index in range(-fresh, 0)],
        }

    @property
    def lanes(self) -> list[dict[str, str]]:
        """The names and labels of the lanes, from top to bottom."""
        own = [{"name": "", "label": "End-effector"}]
        own += [{"name": name, "label": display_name(name)} for name, _ in self._ordered]
        own += [{"name": "tool changer", "label": "Tool changer"}] if self._changer else []
        return [*own, *({"name": f"{SWITCH}{name}", "label": display_name(name)} for name in self._switches)]

    def _note(self, at: int, words: dict[str, str]) -> None:
        for lane, word in words.items():
            if self._last.get(lane) != word:
                self._changes.append({"at": at, "lane": lane, "word": word})
                self.changed += 1
        self._last |= words

    def _words(self, switch: str, level: bool | int | None) -> str:
        return "" if level is None else self._switches[switch].words(bool(level))
