"""A template, drawn as in Fig. 5 of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from timed_automata import Template

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_template(template: Template, constants: Mapping[str, object] | None = None) -> Figure:
    """A template where its file says: locations, edges through their nails, labels in UPPAAL's colours.

    Args:
        template: of a document.
        constants: by name; those that the template mentions are told under its name.

    Save it with `end_effector_lab.figures.save`.

    Raises:
        UsageError: it would be too large to be drawn.
    """
    from end_effector_lab.figures.automata._figure import draw

    return draw(template, constants or {})
