"""The script that installs the services asks for the tool, and copies it with its own automata."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from tests.support.places import DEPLOY


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """A folder as deploy/build.sh makes it, as far as the script uses it."""
    programs = tmp_path / "prefix" / "bin"
    programs.mkdir(parents=True)
    for name, text in (
        ("python", 'exec "$PYTHON" "$@"'),
        ("eehal", 'exec "$PYTHON" -c "from end_effector_hal.cli import main; main()" "$@"'),
    ):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    return programs.parent


def install(prefix: Path, *options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [DEPLOY / "systemd" / "install.sh", *map(str, options), prefix],
        env={**os.environ, "DESTDIR": str(prefix.parent / "root"), "PYTHON": sys.executable},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def units_only(prefix: Path) -> Path:
    """One whose tool has no fault, and no automata of its own: what it takes to find that out is tested above."""
    for name in ("eehal", "python"):
        (prefix / "bin" / name).write_text("#!/bin/sh\n")
    return prefix


def with_ros(prefix: Path, program: str) -> None:
    (prefix / "bin" / program).write_text("#!/bin/sh\n")
    (prefix / "bin" / program).chmod(0o755)
    (prefix / "ros").mkdir()
    (prefix / "ros/setup.bash").touch()


def installed_units(prefix: Path) -> set[str]:
    return {path.stem for path in (prefix.parent / "root/etc/systemd/system").iterdir()}


def test_without_a_tool_nothing_is_installed(prefix: Path) -> None:
    done = install(prefix)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("No tool is driven by default: name yours, ")
    assert not (prefix.parent / "root").exists()


def test_a_description_with_a_fault_is_refused(prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "tool.yaml").write_text("name: tool\n")
    done = install(prefix, "-t", tmp_path / "tool.yaml")
    assert (done.returncode, "[EE-206]" in done.stderr) == (2, True)
    assert not (prefix.parent / "root").exists()


def test_the_tool_and_its_automata_are_copied_once(prefix: Path, tmp_path: Path) -> None:
    own, root = tmp_path / "own", prefix.parent / "root"
    own.mkdir()
    for name in ("end_effector.yaml", "end_effector.xml"):
        shutil.copy(profile_path().with_name(name), own)
    tool = (own / "end_effector.yaml").rename(own / "tool.yaml")
    with_ros(prefix, "eehal-hal")
    assert install(prefix, "-t", tool).returncode == 0
    assert (root / "etc/eehal/end_effector.yaml").read_text() == tool.read_text()
    assert (root / "etc/eehal/end_effector.xml").read_bytes() == (own / "end_effector.xml").read_bytes()
    assert (root / "etc/systemd/system/eehal-hal.service").exists()
    again = install(prefix, "-t", tool)
    assert (again.returncode, again.stderr.startswith("There is a tool already: ")) == (2, True)
    assert install(prefix).returncode == 0


def test_another_description_takes_the_place_of_the_installed_one_if_it_has_no_fault(
    prefix: Path, tmp_path: Path
) -> None:
    tool, installed = tmp_path / "tool.yaml", prefix.parent / "root/etc/eehal/end_effector.yaml"
    tool.write_text(profile_path().read_text())
    early = install(prefix, "-c", tool)
    assert (early.returncode, early.stderr) == (2, "There is no tool yet: name it with -t\n")
    assert install(prefix, "-t", tool).returncode == 0
    first = installed.read_text()
    tool.write_text(first.replace("attempts: 3", "atempts: 3"))
    faulty = install(prefix, "-c", tool)
    assert (faulty.returncode, "[EE-205]" in faulty.stderr, installed.read_text()) == (2, True, first)
    tool.write_text(first.replace("attempts: 3", "attempts: 2"))
    assert install(prefix, "-c", tool).returncode == 0
    assert installed.read_text() == tool.read_text()
    assert installed.with_name("end_effector.yaml.before").read_text() == first


@pytest.mark.parametrize(
    ("program", "units"),
    [
        pytest.param("eehal-hal", {"eehal-hal"}, marks=pytest.mark.thinned),
        ("eehal-hal-ros2", {"eehal-hal-ros2", "eehal-logger-ros2"}),
    ],
)
def test_the_nodes_are_those_of_the_ros_that_the_folder_was_built_for(
    units_only: Path, program: str, units: set[str]
) -> None:
    with_ros(units_only, program)
    done = install(units_only, "-t", profile_path())
    assert (done.returncode, done.stderr) == (0, "")
    assert installed_units(units_only) == {"eehal-arbiter", *units}


def test_without_ros_only_the_line_arbiter_is_installed_and_the_rest_is_named(units_only: Path) -> None:
    done = install(units_only, "-t", profile_path())
    assert done.returncode == 0
    assert installed_units(units_only) == {"eehal-arbiter"}
    first, *lacks, last = done.stderr.splitlines()
    assert first.startswith("Left out: eehal-hal-ros2 eehal-logger-ros2 eehal-hal. ")
    assert lacks == [f"  {units_only}/bin/eehal-hal", f"  {units_only}/bin/eehal-hal-ros2"]
    assert last.endswith("eehal run /etc/eehal/end_effector.yaml")


def test_nodes_whose_workspace_was_not_built_are_left_out(units_only: Path) -> None:
    with_ros(units_only, "eehal-hal")
    (units_only / "ros/setup.bash").unlink()
    done = install(units_only, "-t", profile_path())
    assert installed_units(units_only) == {"eehal-arbiter"}
    assert f"  {units_only}/ros/setup.bash" in done.stderr.splitlines()


def test_systemctl_gets_only_units_that_are_installed() -> None:
    """Enabled, stopped and started: the line arbiter, and the nodes that were found to be able to run."""
    script = (DEPLOY / "systemd" / "install.sh").read_text()
    words = re.findall(r"^(.*)systemctl (?:enable|start|stop|restart) (.*)$", script, re.MULTILINE)
    assert set(words) == {
        ("", "eehal-arbiter $nodes"),
        ('[ -z "$nodes" ] || ', "$nodes"),
        ("", "eehal-arbiter"),
    }
