"""Load the automata of a tool with the constants of its description."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.errors import ModelError, ReportedError
from timed_automata import Network

from ._controller import Controller
from ._network import network_of


def load_automata(description: Description) -> Network:
    """Return the network of a tool with its constants, and check that it can be executed with it.

    Raises:
        ModelError: the UPPAAL file is not valid, or does not fit the description; the error names the place.
    """
    try:
        network = network_of(description)
        Controller(description, network)
    except ReportedError as error:
        named = "automata" in description.model_fields_set
        place = description.where("automata") if named else str(description.automata_path)
        where = error.where or place
        what = " ".join(error.what.removeprefix(where).split())
        raise ModelError(what, where=where, todo=error.todo) from error
    return network
