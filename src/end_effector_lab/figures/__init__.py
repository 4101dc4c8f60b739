"""The figures of runs and of automata; matplotlib is imported only when a figure is drawn."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._recorded_run import STYLES, RecordedRun

if TYPE_CHECKING:
    from ._automaton import draw_template
    from ._paper import paper
    from ._style import save
    from ._timeline import timeline

__all__ = [
    "STYLES",
    "RecordedRun",
    "draw_template",
    "paper",
    "save",
    "timeline",
]
_MADE_IN = {"draw_template": "_automaton", "paper": "_paper", "save": "_style", "timeline": "_timeline"}


def __getattr__(name: str) -> Any:
    """Import a drawing function, and matplotlib with it, at its first use."""
    if name not in _MADE_IN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MADE_IN[name]}", __name__), name)


def __dir__() -> list[str]:
    """Include the lazily imported names, so that the documentation lists them."""
    return sorted({*globals(), *__all__})
