"""Texts on the canvas: where they stand, how large they are, what colour they have. In UPPAAL's pixels."""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_lab.figures._labels import Box, width_of
from end_effector_lab.figures._style import plain

PX_PER_IN = 96
FONT_PX, LINE_PX = 12, 15
FONT_PT = FONT_PX * 72 / PX_PER_IN
_LONGEST = 10_000  # letters of a line

COLOURS = {
    "select": "#8f7400",
    "guard": "#16782f",
    "synchronisation": "#008391",
    "assignment": "#2438c8",
    "invariant": "#96249c",
    "name": "#7c2415",
    "comments": "#68727f",
}
"""Kind of label -> colour: UPPAAL's own, as dark as letters on white need them."""

LEGEND = {
    "select": "select",
    "guard": "guard",
    "synchronisation": "synchronisation",
    "assignment": "update",
    "invariant": "invariant",
    "comments": "comment",
}


@dataclass(frozen=True)
class Words:
    """Lines of one label; ``x`` and ``y`` of its upper left corner."""

    kind: str
    lines: tuple[str, ...]
    x: float
    y: float

    @property
    def box(self) -> Box:
        """What it covers."""
        width = max(width_of(line, FONT_PT) for line in self.lines) * PX_PER_IN
        return Box(self.x, self.y, self.x + width, self.y + LINE_PX * len(self.lines))

    def baseline(self, line: int) -> float:
        """Where a line of letters stands."""
        return self.y + LINE_PX * line + 12


def lines_of(text: str) -> tuple[str, ...]:
    """A text of the file as it is drawn."""
    return tuple(plain(line.expandtabs(4).rstrip(), _LONGEST) for line in text.strip("\n").split("\n"))
