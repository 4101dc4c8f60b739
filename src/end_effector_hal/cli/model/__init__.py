"""``eehal model``: show, simulate, export and check the automata."""

from ._source import DESCRIPTION, MODEL, Source, open_source, the_folder, write_whole

__all__ = ["DESCRIPTION", "MODEL", "Source", "open_source", "the_folder", "write_whole"]
