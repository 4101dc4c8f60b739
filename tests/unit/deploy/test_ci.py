"""What CI runs, and that a test which had to be run once more is never silent."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import ROOT

CALLED = [
    "setup",
    "check",
    "docs",
    "test-dist",
    "test",
    "test-thinned",
    "test-page",
    "kill-matrix",
    "demo",
    "demo-ros2",
    "test-ros2",
    "kill-matrix-ros2",
    "link-campaign",
    "build-kernel.sh",
    "test-gpiochip",
]
STAND_IN = """#!/bin/sh
echo "$1" >>called
case "$1 $2" in
    "test WALL_OPTIONS="*--reruns-log=*) printf 'tests/a.py::b\\nit was late\\n' >>"${2##*--reruns-log=}" ;;
esac
[ "$1" != "$FAILING" ]
"""
FLAKY = """
from pathlib import Path
def test_second_time():
    tried = Path(__file__).with_name("tried")
    assert tried.exists() or tried.touch(), "the first time"
"""


@pytest.mark.parametrize("failing", ["", "check", "test-dist", "test", "build-kernel.sh", "test-gpiochip"])
def test_ci_leaves_nothing_out_and_ends_with_what_was_run_once_more(tmp_path: Path, failing: str) -> None:
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci" / "run", tmp_path / ".ci" / "run")
    make = tmp_path / "make"
    make.write_text(STAND_IN)
    make.chmod(0o755)
    kernel = tmp_path / "tests" / "acceptance" / "gpiochip" / "build-kernel.sh"
    kernel.parent.mkdir(parents=True)
    kernel.write_text("#!/bin/sh\nexec make build-kernel.sh\n")
    kernel.chmod(0o755)
    done = subprocess.run(
        [tmp_path / ".ci" / "run"],
        env={"PATH": f"{tmp_path}:{os.environ['PATH']}", "FAILING": failing},
        stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (tmp_path / "called").read_text().split() == CALLED[: CALLED.index(failing or CALLED[-1]) + 1]
    assert done.returncode == bool(failing), done.stderr
    assert done.stdout.endswith("\ntests/a.py::b\nit was late\n") is (failing not in ("check", "test-dist"))


def test_a_test_that_was_run_again_is_listed_with_why_it_failed_first(tmp_path: Path) -> None:
    shutil.copy(ROOT / "tests" / "conftest.py", tmp_path)
    (tmp_path / "test_flaky.py").write_text(FLAKY)
    log = tmp_path / "reruns.txt"
    options = ["-q", "-p", "no:cacheprovider", "--reruns=1", f"--reruns-log={log}", tmp_path]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert "1 passed, 1 rerun" in done.stdout
    assert "test_flaky.py::test_second_time" in log.read_text()
    assert "AssertionError: the first time" in log.read_text()


def test_make_test_alone_runs_nothing_again() -> None:
    assert "--reruns" not in (ROOT / "Makefile").read_text()
    assert "--reruns" not in (ROOT / "pyproject.toml").read_text()
