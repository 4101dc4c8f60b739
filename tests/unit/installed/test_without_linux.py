"""What looks at a tool and at its recordings needs no Linux; the core loads no wires."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.blocked import eehal_without
from tests.support.nightly import first_of
from tests.support.recorded_tool import recorded
from tests.support.refuted import REFUTED

BLOCKED = ("fcntl", "termios", "pwd", "grp", "gpiod", "inotify_simple")


def eehal(*words: object) -> subprocess.CompletedProcess[str]:
    return eehal_without(BLOCKED, *words)


@pytest.mark.parametrize(
    "words", first_of([("check",), ("model", "check"), ("schema",), ("model", "simulate")])
)
def test_a_tool_is_looked_at(words: tuple[str, ...]) -> None:
    done = eehal(*words)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_network_is_verified_and_a_counterexample_written(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(REFUTED, encoding="utf-8")
    done = eehal("verify", "--model", tmp_path / "model.xml", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (4, "")
    written = {path.name for path in (tmp_path / "out" / "stays").iterdir()}
    assert {"run.txt", "states.csv", "run.json"} <= written


def test_a_run_of_the_model_is_written(tmp_path: Path) -> None:
    done = eehal("model", "simulate", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert {"run.txt", "states.csv", "run.json"} <= {path.name for path in (tmp_path / "out").iterdir()}


def test_a_recording_is_replayed(tmp_path: Path) -> None:
    done = eehal("replay", recorded(tmp_path / "run", "nominal", 1.0, "grip", 1.0))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
def test_a_recording_is_drawn(tmp_path: Path) -> None:
    eehal("model", "simulate", "-o", tmp_path / "out")
    done = eehal("plot", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")


def test_what_needs_linux_says_so(tmp_path: Path) -> None:
    done = eehal("testbench", "--lines", f"virtual:{tmp_path / 'chip'}", "--port", f"pty:{tmp_path / 'uart'}")
    assert done.returncode == 2
    assert done.stderr.startswith("This command needs Linux: there is no module ")


@pytest.mark.parametrize("module", ["end_effector_hal.control", "end_effector_hal.codecs", "timed_automata"])
def test_the_core_loads_no_wires(module: str) -> None:
    wires = ("serial", "inotify_simple", "gpiod", "fcntl", "matplotlib", "numpy", "end_effector_hal.wires")
    seen = f"import sys, {module}\nprint(sorted(name for name in {wires} if name in sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", seen], text=True) == "[]\n"
