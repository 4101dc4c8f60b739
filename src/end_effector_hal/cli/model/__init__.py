"""``eehal model``: show, simulate, export and check the automata."""

from ._source import COILS, DESCRIPTION, MODEL, Source, open_source

__all__ = ["COILS", "DESCRIPTION", "MODEL", "Source", "open_source"]
