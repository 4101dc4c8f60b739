"""A small description, changed line by line, and the faults that it then has."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import load
from end_effector_hal.errors import DescriptionError

SMALL = """\
name: tool
link:
  port: /dev/ttyS0
sequence: [cup, rod]
actuators:
  cup:
    kind: vacuum
    line: A
    channel: bottom
  rod:
    kind: cylinder
    line: B
    channel: cylinder
tool_changer:
  line: C
"""


def _changed(**lines: str) -> str:
    """SMALL with whole lines replaced: ``changed(L3="  port: 5")``; "" takes a line out."""
    numbered = dict(enumerate(SMALL.splitlines(), start=1))
    numbered |= {int(key[1:]): text for key, text in lines.items()}
    return "".join(f"{line}\n" for line in numbered.values() if line)


@pytest.fixture
def changed() -> Callable[..., str]:
    """Makes SMALL with changed lines."""
    return _changed


@pytest.fixture
def faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[str]]:
    """Loads a text, or SMALL with changed lines, from ``tool.yaml``; returns the faults."""
    monkeypatch.chdir(tmp_path)

    def load_text(text: str | bytes | None = None, **lines: str) -> list[str]:
        content = _changed(**lines) if text is None else text
        Path("tool.yaml").write_bytes(content.encode() if isinstance(content, str) else content)
        try:
            load("tool.yaml")
        except DescriptionError as error:
            return error.faults
        return []

    return load_text
