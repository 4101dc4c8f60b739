"""The simulated hardware at which a tool of a test works."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import profile_path
from end_effector_lab.demo._world import World


@pytest.fixture
def world(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[World]:
    """That of the tool which the module has as ``TOOL``, a text or a file; else of the shipped one."""
    tool = getattr(request.module, "TOOL", profile_path())
    if isinstance(tool, str):
        (tmp_path / "tool.yaml").write_text(tool, encoding="utf-8")
        tool = tmp_path / "tool.yaml"
    with World(load_tool(tool), "nominal", tmp_path) as running:
        yield running
