"""Networks of timed automata from UPPAAL files: this package reads, executes and writes them; the rooms use it.

Subpackages: ``timed_automata.check`` finds the faults of a file, ``simulate`` produces runs, ``explore`` proves
properties, and ``monitor`` judges recorded events.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .document import (
        Document,
        DrawnEdge,
        DrawnLocation,
        Label,
        Template,
        load_document,
        load_source,
        read_document,
        write_document,
    )
    from .execute import (
        Begun,
        Event,
        Execution,
        ExecutionSnapshot,
        Foresight,
        Observation,
        Reaction,
        Received,
        Step,
        TakenEdge,
        Written,
        live,
    )
    from .network import Change, Network, State, Trace, TraceStep, export, load_network, make_network

__all__ = [
    "Begun",
    "Change",
    "Document",
    "DrawnEdge",
    "DrawnLocation",
    "Event",
    "Execution",
    "ExecutionSnapshot",
    "Foresight",
    "Label",
    "Network",
    "Observation",
    "Reaction",
    "Received",
    "State",
    "Step",
    "TakenEdge",
    "Template",
    "Trace",
    "TraceStep",
    "Written",
    "export",
    "live",
    "load_document",
    "load_network",
    "load_source",
    "make_network",
    "read_document",
    "write_document",
]


def __getattr__(name: str) -> Any:
    """Import a public name at its first use: a process that needs only the errors starts without the rest."""
    for room in ("document", "execute", "network") if name in __all__ else ():
        module = import_module(f".{room}", __name__)
        if name in module.__all__:
            return globals().setdefault(name, getattr(module, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
