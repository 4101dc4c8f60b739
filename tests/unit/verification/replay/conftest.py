"""Runs in virtual time, recorded as real ones are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.verification.replay import ProgramTrace
from tests.support.recorded_tool import RecordedTool

Edit = Callable[[dict[str, Any]], object]


@pytest.fixture
def tool(tmp_path: Path) -> Iterator[Callable[..., RecordedTool]]:
    made: list[RecordedTool] = []

    def make(scenario: str = "nominal", **options: Any) -> RecordedTool:
        made.append(RecordedTool(tmp_path / "run", scenario, **options))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture(scope="module")
def gripped(tmp_path_factory: pytest.TempPathFactory) -> ProgramTrace:
    """A grip in which the cylinder fails once, held and dropped."""
    tool = RecordedTool(tmp_path_factory.mktemp("gripped"), "fails-once:cylinder")
    tool.play(1.0, "grip", 10.0, "drop", 2.0)
    assert tool.status.ee == 6
    return tool.trace()


def edited(trace: ProgramTrace, number: int, edit: Edit | None) -> ProgramTrace:
    """With one record changed; ``None``: without it."""
    records = list(trace.file.records)
    if edit is None:
        del records[number]
    else:
        content = records[number].content
        edit(content)
        records[number] = replace(records[number], data=json.dumps(content).encode())
    return replace(trace, file=replace(trace.file, records=tuple(records)))


def numbers(trace: ProgramTrace, kind: str, fits: Callable[[dict[str, Any]], object] = bool) -> list[int]:
    """The records of a kind that fit."""
    return [
        number
        for number, record in enumerate(trace.file.records)
        if record.kind == kind and fits(trace.content(number))
    ]
