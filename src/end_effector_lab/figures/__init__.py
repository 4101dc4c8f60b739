"""The figures of runs, of automata and of grids of numbers; matplotlib is imported only when one is drawn."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._heat_map_cell import HeatMapCell
from ._recorded_run import STYLES, RecordedRun

if TYPE_CHECKING:
    from ._heat_map import heat_map
    from ._overlay import overlay
    from ._paper import paper
    from ._save import save
    from ._timeline import timeline
    from ._tuning import tuning
    from .automata import draw_template

__all__ = [
    "STYLES",
    "HeatMapCell",
    "RecordedRun",
    "draw_template",
    "heat_map",
    "overlay",
    "paper",
    "save",
    "timeline",
    "tuning",
]
_MODULES = {"draw_template": "automata"}
"""Where a function is that is not in the module of its own name."""


def __getattr__(name: str) -> Any:
    """What draws is imported when it is asked for, and matplotlib with it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES.get(name, f'_{name}')}", __name__), name)


def __dir__() -> list[str]:
    """With what is imported later: the documentation lists it."""
    return sorted({*globals(), *__all__})
