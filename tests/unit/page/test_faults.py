"""Faults by the page: what is shown of a testbench; choose, arm, go."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from dataclasses import replace

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError
from end_effector_hal.faults import FaultOffer, TestbenchHeader
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.page.web._control import FaultCommands

S = 1_000_000
LEAK = FaultOffer("leak", "it leaks", "leak:<actuator>", ("top",), anywhere=False)


class Testbench:
    """Says what it was asked, and refuses one text."""

    __test__ = False

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.there, self.now = True, 0
        self.commands = FaultCommands(self.ask, lambda: self.there)

    async def ask(self, word: str, scenario: str) -> Answer:
        self.asked.append((word, scenario))
        return Answer(False, "no fault is named 'leek'.") if scenario == "leek" else Answer(True)

    def obey(self, word: str, scenario: str = "", page: str = "one") -> Answer:
        said: Awaitable[Answer] = self.commands.obey(word, page, f"Page {page}", scenario, lambda: self.now)
        return asyncio.run(_awaited(said))


async def _awaited(said: Awaitable[Answer]) -> Answer:
    return await said


def test_what_was_armed_is_played_once() -> None:
    bench = Testbench()
    assert bench.obey("arm", "leak:top").accepted
    assert bench.asked == [("check", "leak:top")]
    assert bench.commands.shown(0) == {
        "page": "one", "name": "Page one", "scenario": "leak:top", "left_s": 10,
    }  # fmt: skip
    assert bench.obey("go", "leak:top").accepted
    assert bench.asked == [("check", "leak:top"), ("choose", "leak:top")]
    assert bench.commands.shown(0) is None
    assert not bench.obey("go", "leak:top").accepted
    assert len(bench.asked) == 2


def test_nothing_is_played_that_was_not_armed() -> None:
    bench = Testbench()
    assert bench.obey("go", "leak:top").reason.startswith("Arm a scenario first")
    refused = bench.obey("arm", "leek")
    assert (refused.accepted, refused.reason) == (False, "no fault is named 'leek'.")
    assert bench.obey("go", "leek").reason.startswith("Arm a scenario first")
    bench.obey("arm", "leak:top")
    assert bench.obey("go", "no-tool").reason == "Another scenario is armed: leak:top."
    assert bench.obey("go", "leak:top", page="two").reason.startswith("Arm a scenario first")
    assert [word for word, _ in bench.asked] == ["check", "check"]
    assert bench.obey("go", "leak:top").accepted


@pytest.mark.parametrize(("after_us", "played"), [(10 * S - 1, True), (10 * S, False)])
def test_it_is_armed_for_ten_seconds(after_us: int, played: bool) -> None:
    bench = Testbench()
    bench.obey("arm", "leak:top")
    bench.now = after_us
    assert (bench.commands.shown(after_us) is not None) is played
    assert bench.obey("go", "leak:top").accepted is played


def test_a_refused_one_and_another_page_take_its_place() -> None:
    bench = Testbench()
    bench.obey("arm", "leak:top")
    bench.obey("arm", "leek", page="two")
    assert bench.commands.shown(0) is None
    bench.obey("arm", "leak:top")
    bench.obey("arm", "no-tool", page="two")
    assert bench.obey("go", "leak:top").reason.startswith("Arm a scenario first")


def test_nominal_needs_no_arming_and_disarms() -> None:
    bench = Testbench()
    bench.obey("arm", "leak:top")
    assert bench.obey("nominal").accepted
    assert bench.asked[-1] == ("choose", "nominal")
    assert bench.commands.shown(0) is None


def test_what_was_armed_for_a_testbench_that_has_gone_is_not_played_by_the_next() -> None:
    bench = Testbench()
    bench.obey("arm", "leak:top")
    bench.there = False
    assert bench.commands.shown(0) is None
    assert bench.obey("nominal").reason == "No testbench is at the other end of the wires."
    bench.there = True
    assert bench.obey("go", "leak:top").reason.startswith("Arm a scenario first")
    assert bench.asked == [("check", "leak:top")]


@pytest.fixture
def view(verdin: Description) -> FaultsView:
    return FaultsView(verdin, ToolView(verdin, 0).log)


def texts(view: FaultsView) -> list[str]:
    return [entry["text"] for entry in view._log.entries]


def header(tool: Description, content: str = "") -> TestbenchHeader:
    return TestbenchHeader(tool.name, content or content_hash(tool), (LEAK,))


def test_without_a_testbench_it_says_nothing(view: FaultsView) -> None:
    for _ in range(3):
        view.lose("", S)
    assert (view.there, view.now(S), view.version, texts(view)) == (False, None, 0, [])


def test_a_device_that_is_played_from_its_description_is_no_device(
    view: FaultsView, verdin: Description
) -> None:
    units = ("unit 9 plays the description, not the device", "unit 8 plays the model of robotiq-2f85")
    view.begin(replace(header(verdin), units=units), S)
    (said,) = texts(view)
    assert said.endswith(
        "moves. Unit 9 plays the description, not the device. Unit 8 plays the model of robotiq-2f85."
    )


def test_a_testbench_that_comes_changes_and_goes(view: FaultsView, verdin: Description) -> None:
    view.begin(header(verdin), S)
    assert view.now(S) is None, "what is wrong is not known yet"
    view.scenario("nominal", S)
    view.scenario("nominal", 2 * S)
    assert view.now(2 * S) == {"scenario": "nominal", "silent": False}
    assert view.now(3 * S + 1) == {"scenario": "nominal", "silent": True}
    assert [each["name"] for each in view.offered] == ["leak"]
    view.scenario("leak:top", 3 * S)
    assert view.now(3 * S) == {"scenario": "leak:top", "silent": False}
    view.lose("The testbench has ended its connection.", 4 * S)
    view.lose("", 5 * S)
    assert view.now(5 * S) is None
    assert texts(view) == [
        "A testbench is at the other end of the wires: nothing real moves.",
        "The testbench plays: nominal.",
        "The testbench plays: leak:top.",
        "The testbench has ended its connection.",
    ]
    view.begin(header(verdin), 6 * S)
    assert view.version == 2


def test_a_testbench_of_another_tool_is_none(view: FaultsView, verdin: Description) -> None:
    with pytest.raises(ReportedError, match="simulates another description") as refused:
        view.begin(header(verdin, "0123456789ab"), S)
    for _ in range(3):
        view.lose(str(refused.value), S)
    assert view.now(S) is None
    assert len(texts(view)) == 1, "said once"
