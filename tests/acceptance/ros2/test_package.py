"""The package that `ros2 run` and `ros2 launch` find, built with colcon. There is no wheel of either program.

The launch files are compared with the programs and parameters that there are, and each program is started as `ros2 run`
does; `test_launch.py` runs them.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from end_effector_hal.nodes.interface import PARAMETERS
from end_effector_hal.ros2 import PROGRAMS
from tests.support.patience import PATIENCE_S
from tests.support.places import ROOT

PACKAGE = ROOT / "ros" / "end_effector_hal"
LAUNCH_FILES = sorted((PACKAGE / "launch").glob("*.launch.py"))
VERSION_2 = {"ROS_VERSION": "2", "ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": sys.prefix}


def run(*words: object, first_in_path: str = str(Path(sys.executable).parent), **env: str) -> tuple[int, str]:
    """The exit code and all that a program printed."""
    done = subprocess.run(
        [str(word) for word in words],
        env={**os.environ, **VERSION_2, "PATH": f"{first_in_path}:{os.environ['PATH']}", **env},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout


@pytest.fixture
def prefix(installed: Path) -> Path:
    """Where colcon has installed the package."""
    return installed


def test_colcon_installs_what_ros2_looks_for(prefix: Path) -> None:
    share = prefix / "share"
    assert (share / "ament_index/resource_index/packages/end_effector_hal").is_file()
    assert (share / "end_effector_hal/package.xml").is_file()
    launch = sorted(path.name for path in (share / "end_effector_hal/launch").iterdir())
    assert launch == [path.name for path in LAUNCH_FILES]
    programs = {path.name for path in (prefix / "lib/end_effector_hal").iterdir() if os.access(path, os.X_OK)}
    assert programs == {*PROGRAMS, "eehal", "check_launch"}


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_program_is_the_one_that_its_name_says(prefix: Path, program: str) -> None:
    code, said = run(prefix / "lib/end_effector_hal" / program, "--ros-args", "-p", "no_parameter")
    assert (code, said.splitlines()[-1].partition(": ")[0]) == (2, program), said


def test_eehal_and_the_check_of_the_launch_file_are_programs_too(prefix: Path) -> None:
    code, said = run(prefix / "lib/end_effector_hal/eehal", "--version")
    assert (code, said.split(",")[0]) == (0, "eehal")
    code, said = run(prefix / "lib/end_effector_hal/check_launch", "--profile=verdin_gripper")
    assert (code, said.split()[2]) == (0, str(profile_path()))
    code, said = run(prefix / "lib/end_effector_hal/check_launch")
    assert (code, said.startswith("end_effector.launch: No tool is named")) == (2, True)
    assert "Traceback" not in said


def test_an_interpreter_without_the_code_is_a_sentence(prefix: Path) -> None:
    code, said = run(prefix / "lib/end_effector_hal/hal", first_in_path="/usr/bin")
    assert (code, len(said.splitlines())) == (3, 1)
    assert said.startswith(
        "hal: the Python package end_effector_hal is not installed for /usr/bin/python3. Activate"
    )


def test_the_package_hides_no_plug_in_of_the_code(prefix: Path) -> None:
    """Of two distributions with one name Python sees the entry points of the first only."""
    (site,) = (prefix / "lib").glob("python3*/site-packages")
    code, said = run(prefix / "lib/end_effector_hal/eehal", "testbench", "--list", PYTHONPATH=str(site))
    assert code == 0, said


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_a_launch_file_imports_nothing_of_an_environment(path: Path) -> None:
    """The interpreter of `ros2 launch` sees ROS and its own library."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        for name in names:
            assert name.partition(".")[0] in {*sys.stdlib_module_names, "launch", "launch_ros"}, name


def test_the_launch_file_starts_programs_and_gives_parameters_that_there_are() -> None:
    tree = ast.parse((PACKAGE / "launch" / "end_effector.launch.py").read_text(encoding="utf-8"))
    constants = dict(_constants(tree))
    assert {name for group in constants["PROGRAMS"].values() for name in group} <= PROGRAMS.keys()
    nodes = {name: set(PROGRAMS[name]) for name in PROGRAMS}
    takes = {each.name: set(each.nodes) for each in PARAMETERS}
    recorders = {name for name in PROGRAMS if nodes[name] & takes["directory"]}
    assert set(constants["RECORDERS"]) == recorders
    arguments = {name for name, *_ in constants["ARGUMENTS"]}
    assert {"description", "profile", "segment_mb", "keep_mb", "script"} <= arguments & takes.keys()


def _constants(tree: ast.Module) -> Iterator[tuple[str, object]]:
    """Those that can be read without running the file, and those made of them."""
    known: dict[str, object] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            code = compile(ast.Expression(node.value), "constants", "eval")
            known[node.targets[0].id] = eval(code, {"tuple": tuple}, known)  # noqa: S307 our own constants
            yield node.targets[0].id, known[node.targets[0].id]
