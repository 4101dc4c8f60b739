"""The socket of a testbench, if one is at the other end of the wires."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.faults import TestbenchHeader, TestbenchScenario, socket_of_testbench
from end_effector_hal.page.view import FaultsView
from end_effector_hal.wires import now_us

from ._socket_link import SocketLink

_HEADER, _SCENARIO = TypeAdapter(TestbenchHeader), TypeAdapter(TestbenchScenario)


class TestbenchLink(SocketLink):
    """Brings what a testbench says to a view, and asks it.

    Args:
        description: the tool.
        view: gets it.
    """

    __test__ = False  # no test class, whatever pytest thinks of its name
    missing = ""
    """A tool without a testbench is nothing to speak of."""

    def __init__(self, description: Description, view: FaultsView) -> None:
        super().__init__(socket_of_testbench(description), "The testbench", self._gone)
        self._view = view

    async def ask(self, word: str, scenario: str) -> Answer:
        """Whether it could play a scenario (``check``), or play it (``choose``); an answer in any case."""
        return await self.request(word=word, scenario=scenario)

    def read(self, message: dict[str, Any]) -> None:
        if message["kind"] == "header":
            self._view.begin(_HEADER.validate_python(message["content"]), now_us())
        elif message["kind"] == "scenario":
            self._view.scenario(_SCENARIO.validate_python(message["content"]).scenario, now_us())

    def _gone(self, why: str) -> None:
        self._view.lose(why, now_us())
