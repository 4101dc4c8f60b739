"""Templates drawn as in Fig. 5 of the paper; matplotlib is imported only when one is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from end_effector_hal.automata._document import Template

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_template"]


def draw_template(template: Template, constants: Mapping[str, object] | None = None) -> Figure:
    """A template where its file says: locations, edges through their nails, labels in UPPAAL's colours.

    Args:
        template: of a document.
        constants: by name; those that the template mentions are told under its name.

    Save it with `end_effector_hal.trace.save`.

    Raises:
        UsageError: it would be too large to be drawn.
    """
    from end_effector_hal.trace.automata_figure._figure import draw

    return draw(template, constants or {})
