"""The figures of runs and of automata; matplotlib is imported only when a figure is drawn."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._recorded_run import STYLES, RecordedRun

if TYPE_CHECKING:
    from ._paper import paper
    from ._save import save
    from ._timeline import timeline
    from .automata import draw_template

__all__ = [
    "STYLES",
    "RecordedRun",
    "draw_template",
    "paper",
    "save",
    "timeline",
]
_MODULES = {"draw_template": "automata"}
"""Modules of functions that are not in the module of their own name."""


def __getattr__(name: str) -> Any:
    """Import a drawing function, and matplotlib with it, at its first use."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES.get(name, f'_{name}')}", __name__), name)


def __dir__() -> list[str]:
    """Include the lazily imported names, so that the documentation lists them."""
    return sorted({*globals(), *__all__})
