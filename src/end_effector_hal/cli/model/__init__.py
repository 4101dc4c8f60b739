"""``eehal model``: show, simulate, export and check the automata."""

from ._source import NamedNetwork, Source, network_options
