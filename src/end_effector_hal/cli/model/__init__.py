"""``eehal model``: show, simulate, export and check the automata."""

from ._source import DESCRIPTION, MODEL, Source, open_source

__all__ = ["DESCRIPTION", "MODEL", "Source", "open_source"]
