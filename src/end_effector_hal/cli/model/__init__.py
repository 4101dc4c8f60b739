"""``eehal model``: show, simulate, export and check the automata."""

from ._source import DEATHS, DESCRIPTION, MODEL, REGISTERS, Source, open_source
