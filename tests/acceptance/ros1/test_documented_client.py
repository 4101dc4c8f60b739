"""The client of docs/reference/actions.md copes with a HALMain that was killed in the middle of its goal."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState
from tests.support.places import DOCS

pytestmark = pytest.mark.ros
ACTIONS = DOCS / "reference/actions.md"


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """The example, word for word."""
    (code,) = re.findall(r"```python\n(.*?)```", ACTIONS.read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "client.py"
    path.write_text(code, encoding="utf-8")
    return path


def test_the_documented_client_says_how_a_goal_ended(system: Any, program: Path) -> None:
    for action, said in (
        ("TriggerGrip", "succeeded"),
        ("TriggerGrip", "outcome 1: A grip is accepted in STAND_BY only; the end-effector is GRIPPED."),
        ("Drop", "succeeded"),
    ):
        done = system.cli("python3", str(program), action)
        assert done.stdout.strip() == said, done.stderr


def test_the_documented_client_copes_with_a_kill(system: Any, program: Path) -> None:
    system.world.choose("never-confirms:top_vacuum")
    client = system.start("documented", "python3", str(program), "TriggerGrip")
    system.until("the last step", lambda: list(system.state.outputs) == [True, True, True])
    os.kill(system.pid_of("/HALMain"), signal.SIGKILL)
    assert client.wait_for_end(timeout_s=60.0) == 0
    assert "not known; now: state " in client.text()
    assert "succeeded" not in client.text()
    system.world.choose("nominal")
    system.wait_for(EndEffectorState.STAND_BY)  # HALMain ran the tool: the line arbiter has unwound the grip
