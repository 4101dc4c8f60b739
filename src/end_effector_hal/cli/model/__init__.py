"""``eehal model``: show, simulate, export and check the automata."""

from ._source import COILS, DEATHS, DESCRIPTION, MODEL, Source, open_source

__all__ = ["COILS", "DEATHS", "DESCRIPTION", "MODEL", "Source", "open_source"]
