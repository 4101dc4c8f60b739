"""Frames that would change nothing are left out, and nobody can tell: against a tool that plays each of them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.runtime import Program
from end_effector_hal.signals import Frame
from end_effector_lab.testbench import SensorBoard, Sent
from end_effector_lab.trials import Case, CaseSource, play_case
from end_effector_lab.virtual import VirtualTool
from tests.support.nightly import first_of
from tests.support.places import ROOT

SHIPPED = load(profile_path())
FAULTS = (
    "nominal",
    "leak-grows:bottom_vacuum:4",
    "lost-after:top_vacuum:2",
    "frozen-after:top_vacuum:1",
    "silent-after:1",
    "leak:top_vacuum",
    "never-confirms:bottom_vacuum",
    "supply:300",
    "invalid:top_vacuum",
    "reboot-after:1",
)
_SECONDS = re.compile(r"for [0-9.]+ s ")
"""How old the newest frame is that the arbiter was told of: it is told every 40 ms at most, not with each frame."""


def story(tool: VirtualTool) -> list[Any]:
    """All that was done and told, with its times."""
    return [tool.edges, [_SECONDS.sub("", repr(status)) for status in tool.statuses], tool.at]


def play(tool: VirtualTool, fault: str, after: float) -> list[Any]:
    """A grip with a fault on the way, a hold, a drop."""
    tool.run(1.0)
    tool.command("grip")
    tool.run(after)
    tool.choose(fault)
    tool.run(9.0 - after)
    tool.command("drop")
    tool.run(3.0)
    return story(tool)


def both(description: Description, fault: str, after: float) -> None:
    frames: list[Frame] = []
    every = VirtualTool(description, seed=round(after * 100), on_frame=frames.append)
    leaps = VirtualTool(description, seed=round(after * 100))
    assert play(leaps, fault, after) == play(every, fault, after)
    assert len(frames) > 100


@pytest.mark.parametrize("after", first_of([0.41, 2.5], thinned=0))
@pytest.mark.parametrize("fault", first_of(FAULTS, 3, 3))
def test_the_same_at_the_same_times(fault: str, after: float) -> None:
    both(SHIPPED, fault, after)


@pytest.mark.thinned
def test_the_same_for_a_binary_codec(tmp_path: Path) -> None:
    shutil.copytree(profile_path().parent, tmp_path / "tool")
    file = tmp_path / "tool" / profile_path().name
    file.write_text(file.read_text().replace("ees1-ascii", "ees1-cobs"))
    both(load(file), "leak-grows:top_vacuum:2", 1.5)


@pytest.mark.parametrize(
    "name", first_of(["double_acting_jaw", "six_cups", "area_gripper", "diy_text"], 1, 1)
)
def test_the_same_for_other_tools(name: str) -> None:
    tool = load_tool(ROOT / "examples" / "tools" / name / "end_effector.yaml")
    both(tool, f"fails-once:{tool.sequence[0]}", 0.5)


def test_most_frames_at_rest_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    tool = VirtualTool(SHIPPED)
    tool.run(1.0)
    played = played_from_now_on(monkeypatch)
    tool.run(20.0)
    assert tool.at == 21_000_000
    assert 1 <= len(played) < 20  # of 1000


def played_from_now_on(monkeypatch: pytest.MonkeyPatch) -> set[int]:
    """Gets µs of each frame that the program receives."""
    played, real = set[int](), Program.frame

    def receives(program: Program, frame: Frame) -> None:
        played.add(frame.at)
        real(program, frame)

    monkeypatch.setattr(Program, "frame", receives)
    return played


def test_frames_of_a_silent_link_and_those_that_nobody_gets_are_not_made(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[int] = []
    real = SensorBoard.frame

    def frame(board: SensorBoard, at: int) -> Sent:
        made.append(at)
        return real(board, at)

    monkeypatch.setattr(SensorBoard, "frame", frame)
    tool = VirtualTool(SHIPPED)
    silences: tuple[Callable[[], None], ...] = (
        partial(tool.choose, "silent-after:0"),
        partial(tool.kill, "hal"),
    )
    for silence in silences:
        tool.run(1.0)
        silence()
        made.clear()
        tool.run(5.0)
        assert len(made) < 25  # of 250: somebody may look four times a second
        tool.choose("nominal")
        tool.start("hal")


def test_frames_are_left_out_after_a_program_has_begun_again(monkeypatch: pytest.MonkeyPatch) -> None:
    tool = VirtualTool(SHIPPED)
    tool.run(1.0)
    tool.kill("hal")
    tool.start("hal")
    tool.run(1.0)
    played = played_from_now_on(monkeypatch)
    tool.run(5.0)
    assert len(played) < 20  # of 250


def test_a_frame_that_is_asked_for_is_played() -> None:
    frames: list[Frame] = []
    VirtualTool(SHIPPED, on_frame=frames.append).run(2.0)
    assert [frame.at for frame in frames] == list(range(0, 2_000_001, 20_000))


@pytest.mark.parametrize("seed", first_of(range(8), 1, 2))
def test_random_runs_are_the_same(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    case = CaseSource(SHIPPED).fresh(Random(seed))
    assert ended(case) == with_every_frame(case, monkeypatch)


def ended(case: Case) -> list[Any]:
    played = play_case(SHIPPED, case)
    log = [_SECONDS.sub("", line) for line in played.log()]
    return [played.failures, played.moments, played.grips, played.tool.at, played.end, log]


def with_every_frame(case: Case, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    with monkeypatch.context() as patched:
        patched.setattr(VirtualTool, "_leap_of", lambda self, sources: None)
        return ended(case)
