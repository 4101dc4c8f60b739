"""The network of a tool: its UPPAAL file with the constants from its description."""

from __future__ import annotations

import json
from functools import lru_cache

from end_effector_hal.description import Description
from timed_automata import Network, load_source, make_network, read_document

from ._constants import model_constants

_KEPT = 8


def network_of(description: Description) -> Network:
    """Return the network that the HAL of a tool executes.

    It is cached by the content of the file and its constants, because compiling takes a fifth of a second, on a robot's
    computer more than a second. A changed file or constant gives another network.

    Raises:
        ModelError: the UPPAAL file is not valid; with ``file:line:column``.
        UsageError: a constant does not exist in the file, or does not fit its declaration.
    """
    path = description.automata_path
    return _compiled(str(path), load_source(path), json.dumps(model_constants(description)))


@lru_cache(maxsize=_KEPT)
def _compiled(path: str, source: bytes, constants: str) -> Network:
    return make_network(read_document(source, path), json.loads(constants))
