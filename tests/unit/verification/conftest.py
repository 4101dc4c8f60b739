"""Recorded runs that several rooms of these tests take."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.recorded_tool import RecordedTool


@pytest.fixture(scope="session")
def gripped_twice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two grips, each held and dropped; in the first the cylinder fails once."""
    tool = RecordedTool(tmp_path_factory.mktemp("twice") / "run", "fails-once:cylinder")
    tool.run(1.0)
    for seconds in (8.0, 2.0):
        assert tool.command("grip").accepted
        tool.run(seconds)
        assert tool.command("drop").accepted
        tool.run(2.0)
    tool.close()
    return tool.folder
