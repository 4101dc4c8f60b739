"""What looks at a tool and at its recordings needs no Linux; the core loads no wires."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.unit.earlier.conftest import ARCHIVE

BLOCKED = ("fcntl", "termios", "pwd", "grp", "gpiod", "inotify_simple")
WITHOUT = f"""
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {BLOCKED}:
            raise ModuleNotFoundError(f"{{name}} is blocked", name=name)

for name in {BLOCKED}:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Blocked())
"""
EEHAL = f"{WITHOUT}\nfrom end_effector_hal.cli import main\nmain()\n"
MODEL = """<nta><declaration>clock x; int ee = 6, command = -1, actuator[1];</declaration><template><name>P</name>
<location id="a"><name>A</name><label kind="invariant">x &lt;= 3</label></location>
<location id="b"><name>B</name></location>
<init ref="a"/><transition><source ref="a"/><target ref="b"/></transition></template>
<system>system P;</system>
<queries><query><formula>A[] P.A</formula><comment>[stays] It stays.</comment></query></queries></nta>
"""


def eehal(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", EEHAL, *map(str, words)], capture_output=True, text=True, check=False
    )


@pytest.fixture
def run(tmp_path: Path) -> Path:
    shutil.unpack_archive(ARCHIVE, tmp_path)
    return tmp_path / "run"


@pytest.mark.parametrize("words", [("check",), ("model", "check"), ("schema",), ("model", "simulate")])
def test_a_tool_is_looked_at(words: tuple[str, ...]) -> None:
    done = eehal(*words)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_network_is_verified_and_a_counterexample_written(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(MODEL, encoding="utf-8")
    done = eehal("verify", "--model", tmp_path / "model.xml", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (4, "")
    written = {path.name for path in (tmp_path / "out" / "stays").iterdir()}
    assert {"run.txt", "states.csv", "run.json"} <= written


def test_a_run_of_the_model_is_written(tmp_path: Path) -> None:
    done = eehal("model", "simulate", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert {"run.txt", "states.csv", "run.json"} <= {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize("command", ["plot", "replay"])
def test_a_recording_is_read(run: Path, command: str) -> None:
    done = eehal(command, run)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("module", ["end_effector_hal.control", "end_effector_hal.codecs", "timed_automata"])
def test_the_core_loads_no_wires(module: str) -> None:
    wires = ("serial", "inotify_simple", "gpiod", "fcntl", "matplotlib", "numpy", "end_effector_hal.wires")
    seen = f"import sys, {module}\nprint(sorted(name for name in {wires} if name in sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", seen], text=True) == "[]\n"
