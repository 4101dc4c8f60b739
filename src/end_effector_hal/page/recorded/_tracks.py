"""Views at many moments, stored as changes: one track for each value that is shown."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_ABSENT = object()


class Tracks:
    """Stores, for each track, the numbers of the moments at which its value changed, and the new values."""

    def __init__(self) -> None:
        self.times: list[int] = []
        self._last: dict[str, Any] = {}
        self._tracks: dict[str, tuple[list[int], list[Any]]] = {}
        self.changes = 0

    def note(self, at: int, view: dict[str, Any]) -> None:
        """Add the view that is valid from ``at`` µs on."""
        number, leaves = len(self.times), dict(_leaves(view))
        self.times.append(at)
        for path in self._last.keys() - leaves.keys():
            leaves[path] = None
        for path, value in leaves.items():
            if self._last.get(path, _ABSENT) != value:
                self._last[path] = value
                numbers, values = self._tracks.setdefault(path, ([], []))
                numbers.append(number)
                values.append(value)
                self.changes += 1

    def as_json(self) -> dict[str, Any]:
        """Return ``[numbers, values]`` by path; a number is the difference from the one before it."""
        return {path: [_differences(numbers), values] for path, (numbers, values) in self._tracks.items()}


def _leaves(view: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield paths and values: ``state.word``, ``cards.0.values``, ``interlocks.3``, ``automata.Gripper``."""
    state, cards = view["state"], view["cards"]
    yield "state", state is not None
    for name, value in (state or {}).items():
        yield f"state.{name}", value
    for number, card in enumerate(cards or ()):
        for name, value in card.items():
            yield f"cards.{number}.{name}", value
    for number, row in enumerate(view["interlocks"]):
        yield f"interlocks.{number}", row
    for name, where in view["automata"].items():
        yield f"automata.{name}", where


def _differences(numbers: list[int]) -> list[int]:
    return [after - before for before, after in zip([0, *numbers], numbers, strict=False)]
