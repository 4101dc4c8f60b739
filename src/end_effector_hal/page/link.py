"""The page's clients for the sockets of the HAL and of a testbench: records in, commands out."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.faults import TESTBENCH_RECORDS, TestbenchHeader, TestbenchScenario, socket_of_testbench
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.runtime import reset, stop
from end_effector_hal.runtime.boundary import STREAMED
from end_effector_hal.runtime.stream import program_socket
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc.aio import AsyncClient

RESET_S = 5.0


class ToolLink:
    """Passes records to a view, and commands to the HAL.

    Args:
        view: receives the records.
    """

    def __init__(self, description: Description, view: ToolView) -> None:
        self._description, self._view = description, view
        self._workers = {word: ThreadPoolExecutor(1, word) for word in ("stop", "reset")}
        for worker in self._workers.values():
            worker.submit(int).result()  # the thread exists from now on: a command needs no new one
        self._client = AsyncClient(
            program_socket(description),
            "The HAL",
            STREAMED,
            lambda kind, at, record: view.take(kind, at, record, now_us()),
            lambda why: view.lose(why, now_us()),
        )
        self.run = self._client.run
        """Follow the HAL until cancelled."""

    async def command(self, word: str, name: str = "") -> Answer:
        """Request a command of `WORDS`, or ``stop``; always return an answer."""
        if word == "stop":
            return await self._at_the_arbiter("stop", partial(stop, self._description))
        if word == "reset":
            return await self._reset()
        return await self._ask(word, name)

    async def _ask(self, word: str, name: str = "") -> Answer:
        return Answer(*await self._client.request(command=word, name=name))

    async def _reset(self) -> Answer:
        """Reset the tool changer, then the latched faults of the line arbiter, as `EndEffector.reset` does."""
        answers = []
        status = self._view.status()
        if status is not None and status.changer_fault:
            answers.append(await self._reset_changer())
        acknowledged = await self._ask("acknowledge")
        if not acknowledged.accepted:
            answers.append(acknowledged)
        return await self._at_the_arbiter("reset", partial(reset, self._description, bool, *answers))

    async def _at_the_arbiter(self, word: str, ask: Callable[[], Answer]) -> Answer:
        """Send a command to the line arbiter; each word has its own thread: a stop never waits for a reset."""
        return await asyncio.get_running_loop().run_in_executor(self._workers[word], ask)

    async def _reset_changer(self) -> Answer:
        answer = await self._ask("reset")
        until = now_us() + round(RESET_S * 1e6)
        while answer.accepted and now_us() < until:
            await asyncio.sleep(0.05)
            status = self._view.status()
            if status is not None and not status.changer_fault:
                return answer
        status = self._view.status()
        return Answer(False, status.changer_reason if status else "") if answer.accepted else answer


class TestbenchLink:
    """Passes the records of a testbench to a view, and requests to the testbench.

    Args:
        view: receives the records.
    """

    __test__ = False  # no test class for pytest

    def __init__(self, description: Description, view: FaultsView) -> None:
        self._view = view
        self._client = AsyncClient(
            socket_of_testbench(description),
            "The testbench",
            TESTBENCH_RECORDS,
            self._take,
            lambda why: view.lose(why, now_us()),
            missing="",  # a tool without a testbench needs no sentence
        )
        self.run = self._client.run
        """Follow the testbench until cancelled."""

    async def ask(self, word: str, scenario: str) -> Answer:
        """Check a scenario (``check``) or play it (``choose``); always return an answer."""
        return Answer(*await self._client.request(word=word, scenario=scenario))

    def _take(self, kind: str, at: int, content: TestbenchHeader | TestbenchScenario | None) -> None:
        if isinstance(content, TestbenchHeader):
            self._view.begin(content, now_us())
        elif isinstance(content, TestbenchScenario):
            self._view.scenario(content.scenario, now_us())
