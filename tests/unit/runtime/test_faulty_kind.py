"""A kind of somebody else's fails while the tool runs: what is held stays held, an alarm says why."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.errors import ArbiterError, UsageError
from end_effector_hal.kinds import get_kind
from end_effector_hal.nodes._hal_main import Aggregate
from end_effector_hal.runtime.boundary import open_recorder
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from tests.unit.kinds.faulty_kind import broken, described
from tests.unit.runtime.test_program import Tool, gripping


def fail() -> Any:
    raise KeyError("nothing of the sort")


def leave() -> Any:
    raise SystemExit("a kind ends its thread")


class Unspeakable(BaseException):
    def __str__(self) -> str:
        raise ValueError


def say_nothing() -> Any:
    raise Unspeakable


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    points = EntryPoints(
        [EntryPoint("faulty", "tests.unit.kinds.faulty_kind:Faulty", "end_effector_hal.kinds")]
    )
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **kw: points.select(**kw))
    get_kind.cache_clear()
    yield
    broken.clear()
    get_kind.cache_clear()


@pytest.fixture
def tool(tmp_path: Path) -> Iterator[Tool]:
    """Recorded, as on a robot."""
    description = described()
    tool = Tool(description, open_recorder(tmp_path, description, at=1_000_000))
    tool.run(60)
    yield tool
    tool.program._recorder.close()


def gripped(tool: Tool) -> None:
    tool.play("grip", 100)
    assert tool.program.status.ee is EndEffectorState.GRIPPED


def told(tool: Tool, what: str) -> list[str]:
    return [alarm for alarm in tool.program.status.alarm_texts if what in alarm]


@pytest.mark.parametrize(
    ("method", "how", "why"),
    [
        ("FaultyDetector.sample()", fail, "KeyError: 'nothing of the sort'"),
        ("FaultyDetector.sample()", leave, "SystemExit: a kind ends its thread"),
        ("FaultyDetector.sample()", say_nothing, "Unspeakable"),
        ("FaultyDetector.sample()", lambda: 3, "TypeError: int is no Evidence"),
        ("FaultyDetector.MEMORY", fail, "AttributeError: "),
        ("FaultyWatch.sample()", fail, "KeyError: 'nothing of the sort'"),
        ("FaultyWatch.findings()", fail, "KeyError: 'nothing of the sort'"),
        ("FaultyWatch.findings()", lambda: None, "TypeError: 'NoneType' object is not iterable"),
        ("FaultyWatch.findings()", lambda: [("leak", 3, None)], "ValueError: a finding that is neither WEAK nor LEAK"),
    ],
)  # fmt: skip
def test_what_fails_while_a_part_is_held_lets_nothing_go(
    tool: Tool, method: str, how: Callable[[], Any], why: str
) -> None:
    gripped(tool)
    broken[method] = how
    tool.run(20)
    status = tool.program.status
    assert (status.ee, status.held) == (EndEffectorState.GRIPPED, True)
    assert all(gripping(tool))
    (alarm,) = told(tool, why)
    assert f"{method} failed with {why}" in alarm
    if "Detector" in method:
        assert alarm.startswith("Top vacuum is not judged reliably: ")
        assert (status.evidence[2], status.secure) == (Evidence.UNKNOWN, False)
    else:
        assert alarm.startswith("Top vacuum is not watched reliably: ")
        assert not status.secure
    broken.clear()
    tool.run(30)
    assert tool.program.status.evidence == (Evidence.CONFIRMED,) * 3
    assert told(tool, why) == [alarm]
    broken["FaultyWatch.dropped()"] = fail
    tool.play("drop", 100)
    assert tool.program.status.ee is EndEffectorState.STAND_BY
    assert not any(tool.lines.active.values())
    assert tool.program.alive
    if "Watch" in method:  # a Drop and a look of an operator end no defect
        tool.program.acknowledge()
        tool.run(1)
        assert told(tool, why) == [alarm]
    assert not tool.program.status.alarm_texts[0].startswith("The trace")


def test_what_is_not_proven_yet_after_a_failure_is_no_loss(tool: Tool) -> None:
    gripped(tool)
    broken["FaultyDetector.sample()"] = fail
    tool.run(1)
    broken.clear()
    seen = []
    for _ in range(10):
        tool.run(1)
        seen.append(tool.program.status.evidence[2])
    assert set(seen) == {Evidence.UNKNOWN, Evidence.CONFIRMED}
    assert tool.program.status.ee is EndEffectorState.GRIPPED


def test_a_loss_whose_words_fail_is_told_all_the_same(tool: Tool) -> None:
    gripped(tool)
    broken["Faulty.lost()"] = fail
    top = tool.description.actuators["top_vacuum"].channel
    frame = tool.frame
    tool.frame = lambda: (one := frame(), type(one)(one.at, one.seq, one.device_ms, {**one.values, top: 0}))[
        1
    ]  # type: ignore[method-assign]
    tool.run(20)
    status = tool.program.status
    assert status.ee is EndEffectorState.GRIP_ERROR
    assert "Top vacuum was lost: its sensor shows nothing any more (Faulty.lost() failed" in status.reason


@pytest.mark.parametrize("method", ["Faulty.detector()", "Faulty.hold_watch()", "Faulty.plausible()"])
def test_a_restart_outlives_what_fails_in_it(tool: Tool, method: str) -> None:
    gripped(tool)
    broken[method] = fail
    tool.lines.away = True
    tool.program.arbiter_lost(ArbiterError("it is away."))
    tool.run(20)
    tool.lines.active = dict.fromkeys(tool.lines.active, False)
    tool.lines.away = False
    tool.run(200)
    status = tool.program.status
    proven = Evidence.UNKNOWN if method == "Faulty.detector()" else Evidence.GONE
    assert status.evidence[2] is proven
    assert bool(told(tool, f"{method} failed with KeyError")) is (method != "Faulty.plausible()")
    assert status.ee is not EndEffectorState.GRIPPED
    assert tool.program.alive


def test_a_margin_that_fails_is_not_known_and_is_told(tool: Tool) -> None:
    aggregate = Aggregate(tool.description, 0)

    def state() -> Any:
        return aggregate.message(tool.program.status, {"top": -80_000}, 0, count=0, stamp_us=None)

    said = "Faulty.margin_pa() failed with KeyError: 'nothing of the sort'."
    assert said not in state().alarms
    broken["Faulty.margin_pa()"] = fail
    assert math.isnan(state().margins[2])
    assert said in state().alarms


@pytest.mark.parametrize(
    ("method", "how"),
    [
        ("Faulty.plausible()", lambda: (0, 1)),
        ("Faulty.channel_names()", lambda: [3]),
        ("Faulty.limits()", lambda: {"a": math.nan}),
    ],
)
def test_what_the_tool_is_made_of_is_refused_in_one_sentence(method: str, how: Callable[[], Any]) -> None:
    broken[method] = how
    description = described()
    actuator, kind = description.actuators["top_vacuum"], get_kind("faulty")
    ask = getattr(kind, method.removeprefix("Faulty.").removesuffix("()"))
    with pytest.raises(UsageError) as caught:
        ask(actuator, description.supply) if "limits" in method else ask(actuator)
    assert str(caught.value).startswith(f"{method} failed with ")


def test_a_tool_that_cannot_be_put_together_is_one_sentence() -> None:
    broken["Faulty.plausible()"] = fail
    with pytest.raises(UsageError, match=r"Faulty.plausible\(\) failed with KeyError"):
        Tool(described())
