"""What needs an extra, Linux or a plug-in that hangs says so; the rest works without it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from end_effector_hal import _extras
from end_effector_hal._extras import DISTRIBUTION, extras
from end_effector_hal.cli import _main
from end_effector_hal.cli.doctor import _machine
from end_effector_hal.cli.doctor._check_result import Level
from end_effector_hal.description import SHIPPED_AUTOMATA, profile_path
from end_effector_lab.processes import EEHAL
from tests.support.blocked import eehal_without
from tests.support.nightly import first_of
from tests.support.places import ROOT
from tests.support.recorded_tool import recorded
from tests.support.refuted import REFUTED

INSTALL_LAB = "which is not installed. Install it: pip install '.[lab]' in a checkout of end-effector-hal.\n"
NO_FIGURE = f"Note: There is no figure. Figures need matplotlib, {INSTALL_LAB}"


def test_the_extras() -> None:
    assert extras() == {
        "bags": ("rosbags",),
        "cluster": ("distributed",),
        "lab": ("matplotlib", "mcap"),
        "modbus": ("pymodbus",),
        "page": ("prometheus-client", "starlette", "uvicorn"),
        "recordings": ("mcap",),
    }


def test_a_module_is_found_under_the_name_of_its_package() -> None:
    missing = _extras.missing_extra("It needs", ModuleNotFoundError(name="prometheus_client.core"))
    assert "[page]" in missing.todo


WORKSHOP = ("campaign", "compare", "demo", "import", "matrix", "plot", "report", "testbench", "tune")


def test_the_workshop_is_what_its_entry_points_say() -> None:
    points = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    assert sorted(points["end_effector_hal.commands"]) == sorted(_main._WORKSHOP) == sorted(WORKSHOP)
    assert set(_extras._LAB) < set(extras()["lab"]), "a simulation needs no figures"


def test_without_the_extra_there_are_no_commands_of_the_workshop() -> None:
    done = eehal_without(["mcap"], "--help")
    names = {line.split()[0] for line in done.stdout.splitlines() if line.startswith("  ") and line.split()}
    assert done.returncode == 0
    assert {"run", "verify", "replay", "page"} <= names
    assert not names & set(WORKSHOP)


@pytest.mark.parametrize("name", first_of(WORKSHOP, 1))
def test_a_command_of_the_workshop_says_what_to_install(name: str) -> None:
    done = eehal_without(["mcap"], name)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"`eehal {name}` needs the extra lab, which is not installed. "
        "Install it: pip install '.[lab]' in a checkout of end-effector-hal.\n"
    )


def test_an_option_of_the_workshop_is_hidden_and_says_what_to_install(tmp_path: Path) -> None:
    for path in (profile_path(), SHIPPED_AUTOMATA):
        shutil.copy(path, tmp_path)
    listed = "Without hardware: virtual lines"
    assert listed in eehal_without([], "run", "--help").stdout
    assert listed not in eehal_without(["mcap"], "run", "--help").stdout
    done = eehal_without(["mcap"], "run", "end_effector.yaml", "--simulate", "--json", cwd=tmp_path)
    (fault,) = json.loads(done.stdout)["faults"]
    assert (done.returncode, fault["code"]) == (2, "EE-101")
    assert "'.[lab]'" in done.stdout


def test_import(tmp_path: Path) -> None:
    done = eehal_without(["rosbags"], "import", tmp_path / "run.bag")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "This command needs rosbags, which is not installed. "
        "Install it: pip install '.[bags]' in a checkout of end-effector-hal.\n"
    )


def test_a_cluster(tmp_path: Path) -> None:
    done = eehal_without(
        ["distributed"], "matrix", "--scheduler", "tcp://127.0.0.1:1", "-o", tmp_path / "runs"
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "This command needs distributed, which is not installed. "
        "Install it: pip install '.[cluster]' in a checkout of end-effector-hal.\n"
    )


def test_a_recording_is_replayed_with_the_extra(tmp_path: Path) -> None:
    run = recorded(tmp_path, "nominal", 1.0, "grip", 1.0)
    done = eehal_without(["mcap"], "replay", run)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "This command needs mcap, which is not installed. "
        "Install it: pip install '.[recordings]' in a checkout of end-effector-hal.\n"
    )


def test_model_show(tmp_path: Path) -> None:
    done = eehal_without(["matplotlib"], "model", "show", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"Figures need matplotlib, {INSTALL_LAB}"


def test_verify_writes_text_and_states(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(REFUTED, encoding="utf-8")
    done = eehal_without(["matplotlib"], "verify", "--model", "model.xml", "-o", "out", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (4, NO_FIGURE)
    assert {path.name for path in (tmp_path / "out" / "stays").iterdir()} == {
        "run.txt", "events.csv", "states.csv", "run.json",
    }  # fmt: skip


def test_simulate_writes_text_and_states(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(REFUTED, encoding="utf-8")
    done = eehal_without(
        ["matplotlib"], "model", "simulate", "--model", "model.xml", "-o", "out", cwd=tmp_path
    )
    assert (done.returncode, done.stderr) == (0, NO_FIGURE)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "run.txt", "events.csv", "states.csv", "run.json",
    }  # fmt: skip


@pytest.mark.parametrize("command", ["--help", "check"])
def test_what_needs_none(command: str) -> None:
    done = eehal_without(["matplotlib", "numpy", "pymodbus", "rosbags"], *command.split())
    assert (done.returncode, done.stderr) == (0, "")


def test_virtual_time_needs_no_modbus_for_a_tool_without_a_bus(tmp_path: Path) -> None:
    done = eehal_without(["pymodbus"], "campaign", "--runs", "1", "--jobs", "1", "--json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert (told["schema_version"], told["runs"]) == (1, 1)


def test_a_modbus_codec(tmp_path: Path) -> None:
    text = profile_path().read_text(encoding="utf-8").replace("codec: ees1-ascii", "codec: modbus-rtu-epick")
    (tmp_path / "tool.yaml").write_text(text, encoding="utf-8")
    shutil.copy(SHIPPED_AUTOMATA, tmp_path)
    done = eehal_without(["pymodbus"], "check", "tool.yaml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    line, *_ = done.stderr.splitlines()
    assert line.endswith(
        ": The codec modbus-rtu-epick needs pymodbus, which is not installed; "
        "Install it: pip install '.[modbus]' in a checkout of end-effector-hal [EE-226]"
    )


def test_the_doctor_says_which_extra_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_machine, "version_of", lambda name: name != "matplotlib")
    (finding,) = (each for each in _machine.look_at_python() if "extra" in each.what)
    what = "the extra lab is not installed (matplotlib, mcap)"
    assert (finding.level, finding.what) == (Level.WARNING, what)
    needed = "Needed by figures, simulations and trials only: "
    assert finding.todo == f"{needed}pip install '.[lab]' in a checkout of end-effector-hal"
    monkeypatch.setattr(_machine, "version_of", lambda name: name == DISTRIBUTION)
    told = [each for each in _machine.look_at_python() if "extra" in each.what]
    assert [each.what.split()[2] for each in told] == [*extras()]
    assert all(each.todo.startswith("Needed by ") for each in told)
    monkeypatch.setattr(_machine, "version_of", lambda name: True)
    assert not [each for each in _machine.look_at_python() if "extra" in each.what]


# What looks at a tool and at its recordings needs no Linux; the core loads no wires.


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


# A plug-in whose import does not end disturbs nobody who does not use it.


GROUPS = ("codecs", "kinds", "physics", "commands")


@pytest.fixture
def hanging(tmp_path: Path) -> Path:
    """A distribution that adds a plug-in `evil` of every sort."""
    (tmp_path / "evil.py").write_text("import time\nprint('imported', flush=True)\ntime.sleep(600)\n")
    info = tmp_path / "evil-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1\n")
    points = (f"[end_effector_hal.{group}]\nevil = evil:Evil\n" for group in GROUPS)
    (info / "entry_points.txt").write_text("\n".join(points))
    return tmp_path


@pytest.mark.parametrize("words", [("check",), ("doctor", "--only", "description,python", "--json")])
def test_who_does_not_use_it_does_not_import_it(hanging: Path, words: tuple[str, ...]) -> None:
    tools = (profile_path(), ROOT / "examples/tools/double_acting_jaw/end_effector.yaml")
    bad = hanging / "bad.yaml"  # hints are looked for in all kinds
    bad.write_text(tools[1].read_text().replace("kind: gripper", "kind: gripper\n    colour: red"))
    path = os.pathsep.join((str(hanging), os.environ.get("PYTHONPATH", "")))
    for tool, code in ((tools[0], 0), (tools[1], 0), (bad, 2)):
        done = subprocess.run(
            [*EEHAL, *words, str(tool)],
            env=os.environ | {"PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert (done.returncode, "imported" in done.stdout) == (code, False), done.stdout + done.stderr
