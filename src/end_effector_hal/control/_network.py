"""The network of a tool: its UPPAAL file with the constants of its description."""

from __future__ import annotations

import json
from functools import lru_cache

from end_effector_hal.description import Description
from timed_automata import Network, load_source, make_network, read_document

from ._constants import model_constants

_KEPT = 8


def network_of(description: Description) -> Network:
    """The network that both programs of a tool execute.

    The same file with the same constants gives the same network: compiling takes half a second, on a robot's computer
    several. A file or a constant that has changed gives another one.

    Raises:
        ModelError: the UPPAAL file is not valid; with ``file:line:column``.
        UsageError: a constant does not exist there, or does not fit its declaration.
    """
    path = description.automata_path
    return _compiled(str(path), load_source(path), json.dumps(model_constants(description)))


@lru_cache(maxsize=_KEPT)
def _compiled(path: str, source: bytes, constants: str) -> Network:
    return make_network(read_document(source, path), json.loads(constants))
