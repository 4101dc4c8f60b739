"""What takes long says so: on stderr, never with JSON."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.support.terminal import on_a_terminal

pytestmark = pytest.mark.wall
SLOW = """\
import sys, time
from end_effector_hal.cli import Progress
with Progress("Working", shown=sys.argv[1] == "words") as progress:
    time.sleep(1.3)
    progress("Still working")
    time.sleep(0.5)
    progress.clear()
    print("found")
"""


def test_a_line_appears_after_a_second_says_what_is_done_and_goes() -> None:
    code, text = on_a_terminal([sys.executable, "-c", SLOW, "words"])
    assert code == 0
    assert "Working, 1 s" in text
    assert "Still working, 1 s" in text
    assert text.endswith("found\n")


def test_with_json_there_is_none() -> None:
    assert on_a_terminal([sys.executable, "-c", SLOW, "json"]) == (0, "found\n")


def piped(program: str) -> tuple[str, str]:
    done = subprocess.run(
        [sys.executable, "-c", program, "words"], capture_output=True, text=True, check=True
    )
    return done.stdout, done.stderr


def test_in_a_log_there_is_none_of_what_is_done_within_half_a_minute() -> None:
    assert piped(SLOW) == ("found\n", "")


def test_in_a_log_what_takes_longer_is_a_line_now_and_then() -> None:
    short = "from end_effector_hal.cli import _output\n_output.LINE_S = 0.6\n"
    found, said = piped(short + SLOW)
    assert found == "found\n"
    assert said.splitlines()[0] == "Working, 1 s"
    assert "\x1b" not in said
    assert "\r" not in said
