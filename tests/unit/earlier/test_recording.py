"""A recording of version 0.1 is replayed, judged and drawn, and its tool can be taken up again."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from end_effector_hal.cli import main
from end_effector_hal.recording import read_trace
from end_effector_hal.runtime.boundary import DESCRIPTION, MODEL


@pytest.fixture
def eehal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    def call(*words: object) -> tuple[object, str]:
        monkeypatch.setattr(sys, "argv", ["eehal", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capsys.readouterr()
        assert err == ""
        return end.value.code, out

    return call


def test_it_is_replayed_and_judged(eehal, earlier: Path) -> None:  # type: ignore[no-untyped-def]
    code, out = eehal("replay", earlier / "run")
    assert code == 0
    assert out.count("decisions, all identical") == 2
    assert out.count(" steps, all allowed by the automata") == 2


def test_it_is_drawn(eehal, earlier: Path) -> None:  # type: ignore[no-untyped-def]
    code, out = eehal("plot", earlier / "run")
    assert code == 0
    told, *files = out.splitlines()
    assert told == "Grip CANCELLED while Cylinder was pending, released in reverse order"
    assert files == [str(earlier / "run" / f"timeline.{suffix}") for suffix in ("png", "svg")]


def test_its_tool_with_its_own_automata_is_valid(eehal, earlier: Path) -> None:  # type: ignore[no-untyped-def]
    """Who has copied the shipped tool and its automata then can use them."""
    files = read_trace(earlier / "run" / "grip.mcap").attachments
    for name in (DESCRIPTION, MODEL):
        (earlier / name).write_bytes(files[name])
    for command in (("check",), ("model", "check")):
        code, out = eehal(*command, earlier / DESCRIPTION)
        assert code == 0, out
