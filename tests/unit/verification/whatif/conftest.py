"""Recorded runs of the virtual tool, and descriptions that differ from its own in one value."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.page.recorded import RecordingFiles
from tests.support.recorded_tool import RecordedTool

Other = Callable[..., Description]


@pytest.fixture(scope="session")
def gripped_twice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two grips, each held and dropped; in the first the cylinder fails once."""
    tool = RecordedTool(tmp_path_factory.mktemp("twice") / "run", "fails-once:cylinder")
    tool.run(1.0)
    for _ in range(2):
        assert tool.command("grip").accepted
        tool.run(9.0)
        assert tool.command("drop").accepted
        tool.run(3.0)
    tool.close()
    return tool.folder


@pytest.fixture
def files(gripped_twice: Path) -> RecordingFiles:
    return RecordingFiles(gripped_twice)


@pytest.fixture
def other(tmp_path: Path) -> Other:
    """The shipped tool with some of its text exchanged."""

    def make(*changes: tuple[str, str]) -> Description:
        text = profile_path().read_text()
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / "other.yaml"
        path.write_text(text)
        return load(path)

    return make
