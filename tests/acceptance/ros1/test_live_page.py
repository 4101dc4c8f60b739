"""The live page with the nodes of ROS: it reads the socket of the HAL, and needs no ROS."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from end_effector_hal.page.link import ToolLink
from end_effector_hal.page.view import ToolView
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.ros


async def grip_and_drop(system: Any) -> ToolView:
    view = ToolView(system.world.description, now_us())
    link = ToolLink(system.world.description, view)
    following = asyncio.create_task(link.run())

    async def until(what: Callable[[dict[str, Any]], bool]) -> None:
        end = now_us() + round(PATIENCE_S * 1e6)
        while not what(view.now(now_us())):
            assert now_us() < end, view.now(now_us())
            await asyncio.sleep(0.05)

    await until(lambda now: now["news"]["fresh"] and now["buttons"]["grip"] == "")
    refused = view.refusal("drop")
    answer = await link.command("drop")
    assert (answer.accepted, answer.reason) == (False, refused)
    assert (await link.command("grip")).accepted
    await until(lambda now: now["state"]["word"] == "GRIPPED")
    await asyncio.to_thread(system.wait_for, EndEffectorState.GRIPPED)
    unlock = await link.command("unlock")
    assert (unlock.accepted, unlock.reason) == (False, view.refusal("unlock"))
    assert (await link.command("drop")).accepted
    await until(lambda now: now["state"]["word"] == "STAND_BY")
    await asyncio.to_thread(system.wait_for, EndEffectorState.STAND_BY)
    reset = await link.command("reset")
    assert reset.accepted, reset.reason
    following.cancel()
    return view


def test_the_page_follows_and_commands_the_nodes(system: Any) -> None:
    view = asyncio.run(grip_and_drop(system))
    texts = [entry["text"] for entry in view.log.entries]
    assert "State GRIPPED" in texts
    assert "Grip accepted." in texts
