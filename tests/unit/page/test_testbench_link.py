"""The page's side of a testbench's socket, with a real testbench at the other one."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from tempfile import mkdtemp

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.page.link import TestbenchLink
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.page.web._control import FaultCommands
from end_effector_hal.wires import now_us
from end_effector_lab.testbench import Testbench, open_inputs, open_ports, write_virtual_copy
from end_effector_lab.testbench._faults import FaultServer
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.wall


@pytest.fixture
def tool(verdin: Description) -> Description:
    return load(write_virtual_copy(verdin, Path(mkdtemp(prefix="eehal-faults-"))))


async def until(what: Callable[[], bool]) -> None:
    end = now_us() + round(PATIENCE_S * 1e6)
    while not what():
        assert now_us() < end
        await asyncio.sleep(0.02)


def test_it_is_found_asked_lost_and_found_again(tool: Description) -> None:
    view = FaultsView(tool, ToolView(tool, now_us()).log)
    link = TestbenchLink(tool, view)
    commands = FaultCommands(link.ask, lambda: view.there)
    bench = Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None))

    async def play() -> None:
        following = asyncio.create_task(link.run())
        await asyncio.sleep(0.5)
        assert not view.there
        assert not view._log.entries, "a tool without a testbench is nothing to speak of"
        assert (await link.ask("choose", "no-tool")).reason == "There is no connection to the testbench."
        with ExitStack() as running:
            running.enter_context(bench)
            server = running.enter_context(FaultServer(tool, bench, lambda _: None))
            await until(lambda: view.there)
            refused = await commands.obey("arm", "one", "Page 1", "leek", now_us)
            assert refused.reason == "no fault is named 'leek'. Did you mean 'leak'?"
            assert (await commands.obey("arm", "one", "Page 1", "leak:top_vacuum", now_us)).accepted
            assert bench.scenario == "nominal"
            assert (await commands.obey("go", "one", "Page 1", "leak:top_vacuum", now_us)).accepted
            assert bench.scenario == "leak:top_vacuum"
            await until(lambda: (view.now(now_us()) or {}).get("scenario") == "leak:top_vacuum")
            await asyncio.to_thread(server.close)
            await until(lambda: not view.there)
            with FaultServer(tool, bench, lambda _: None):
                await until(lambda: view.there and view.version == 2)
                assert (await commands.obey("nominal", "one", "Page 1", "", now_us)).accepted
                assert bench.scenario == "nominal"
        await until(lambda: not view.there)
        following.cancel()

    asyncio.run(play())


def test_a_testbench_of_another_description_is_not_shown(tool: Description) -> None:
    other = tool.model_copy(update={"summary": "another one"})
    view = FaultsView(other, ToolView(other, now_us()).log)
    bench = Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None))

    async def play() -> None:
        following = asyncio.create_task(TestbenchLink(other, view).run())
        await until(lambda: bool(view._log.entries))
        assert "simulates another description" in view._log.entries[0]["text"]
        assert not view.there
        following.cancel()

    with bench, FaultServer(tool, bench, lambda _: None):
        asyncio.run(play())
