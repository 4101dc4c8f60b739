"""What CI runs, and that a test which had to be run once more is never silent."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest
from _pytest.mark.expression import Expression

from tests.support.places import ROOT

CALLED = [
    "setup", "check", "docs", "test-dist", "test", "test-thinned", "test-page", "kill-matrix",
    "matrix-processes", "demo", "test-readme", "test-ros2", "kill-matrix-ros2", "link-campaign",
    "build-kernel.sh", "test-gpiochip",
]  # fmt: skip
STAND_IN = """#!/bin/sh
echo "$1" >>called
case "$* $WALL" in
    "test "*/.ci/once-more*) printf 'tests/a.py::b\\nit was late\\n' >>"${WALL##* }" ;;
esac
[ "$1" != "$FAILING" ]
"""
WORKER = ("-n", "1", "--dist", "loadfile")
FLAKY = """
import os
from pathlib import Path
import pytest
TRIED = Path(__file__).with_name("tried")
def test_that_passes():
    with TRIED.open("a") as tried:
        print("passed", file=tried)
def test_second_time():
    with TRIED.open("a") as tried:
        print("tried by", "a worker" if "PYTEST_XDIST_WORKER" in os.environ else "one alone", file=tried)
    assert "tried by one alone" in TRIED.read_text(), "the first time"
@pytest.fixture
def broken():
    assert "tried by one alone" in TRIED.read_text(), "the world is broken"
def test_in_a_broken_world(broken):
    pass
"""
NEVER = """
import pytest
@pytest.mark.parametrize("number", range({count}))
def test_never(number):
    with open("tried", "a") as tried:
        print(number, file=tried)
    assert False, "never"
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


def test_ci_runs_the_command_that_the_readme_names_for_the_tests() -> None:
    """`make test-readme` runs the others."""
    block = (ROOT / "README.md").read_text(encoding="utf-8").partition("```sh\n")[2].partition("```")[0]
    commands = [line.partition("#")[0].strip() for line in block.splitlines()]
    assert "make test" in commands
    assert "stage make test\n" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def once_more(
    folder: Path, text: str, *workers: str
) -> tuple[subprocess.CompletedProcess[str], str, list[str]]:
    """A file of tests through `.ci/once-more`: how it ended, its log, what the tests wrote."""
    shutil.copy(ROOT / "tests" / "conftest.py", folder)
    (folder / "test_flaky.py").write_text(text)
    log = folder / "failures.txt"
    done = subprocess.run(
        [ROOT / ".ci/once-more", log, sys.executable, "-m", "pytest", "-q", *workers, folder],
        cwd=folder, capture_output=True, text=True, check=False,
        env={name: value for name, value in os.environ.items() if name != "PYTEST_XDIST_WORKER"},
    )  # fmt: skip
    return done, log.read_text() if log.exists() else "", (folder / "tried").read_text().splitlines()


def test_what_fails_is_run_once_more_alone_and_listed_with_why_it_failed_first(tmp_path: Path) -> None:
    done, log, tried = once_more(tmp_path, FLAKY, *WORKER)
    assert done.returncode == 0, done.stdout
    assert sorted(tried) == ["passed", "tried by a worker", "tried by one alone"]
    assert log.count("test_flaky.py::test_second_time") == 1
    assert "AssertionError: the first time" in log
    assert "AssertionError: the world is broken" in log


def test_what_passes_is_not_run_again(tmp_path: Path) -> None:
    done, log, tried = once_more(tmp_path, FLAKY.replace("tried by one alone", "tried by"))
    assert (done.returncode, log, sorted(tried)) == (0, "", ["passed", "tried by one alone"]), done.stdout


@pytest.mark.parametrize(("count", "runs"), [(2, 2), (41, 1)])
def test_what_fails_twice_ends_ci_and_what_fails_by_the_dozen_at_once(
    tmp_path: Path, count: int, runs: int
) -> None:
    done, log, tried = once_more(tmp_path, NEVER.format(count=count))
    assert done.returncode == 1
    assert len(tried) == runs * count
    assert log.count("AssertionError: never") >= count


def test_make_test_alone_runs_nothing_again() -> None:
    assert "once-more" not in (ROOT / "Makefile").read_text()


def test_each_test_belongs_to_one_stage() -> None:
    """`make test`, `make test-thinned` and, for what CI leaves out, `make nightly`; whatever its marks are."""
    marks = ("wall", "ros", "alone", "thinned", "nightly")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    stages = [
        Expression.compile(words)
        for words in re.findall(r'pytest [^\n]*-m "([^"]+)"', makefile)
        if set(re.findall(r"\w+", words)) <= {*marks, "not", "or", "and"}
    ]
    for given in product((False, True), repeat=len(marks)):
        marked = dict(zip(marks, given, strict=True))
        if not marked["alone"] or marked["wall"] or marked["ros"]:
            assert [stage.evaluate(marked.__getitem__) for stage in stages].count(True) == 1, marked
