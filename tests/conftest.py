"""For all tests: their reports reach whoever started them, and those of tests that were run once more are kept."""

from __future__ import annotations

import gc
import os
import timeit
from collections.abc import Generator, Iterator
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest
from hypothesis import HealthCheck, settings
from xdist.scheduler import LoadFileScheduling

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.description.reading import _yaml

# how long an example takes says something of the machine only
settings.register_profile(
    "untimed",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    max_examples=1000 if "EEHAL_NIGHTLY" in os.environ else 40,
)
settings.load_profile("untimed")

_TCP_LEFT_OPEN = (
    "ignore:Exception ignored in. <socket.socket fd=[0-9]+, family=2:pytest.PytestUnraisableExceptionWarning"
)
"""rospy leaves TCP sockets to the garbage collector, also while later tests of a worker run; ours are Unix sockets."""

_FAST_S = 0.05
"""On a machine that adds a million squares in this time, two processors keep up with five workers."""

_COLLECT_AFTER = (100_000, 50, 100)
"""Objects, then rounds: texts that are kept fill a worker, and looking at them often takes a tenth of its time."""

_LONGEST = (
    "ros 0",
    "ros 1",
    "contract 0",
    "contract 1",
    "contract 0 in five",
    "contract 1 in five",
    "test_jaw",
    "test_contributing",
    "test_end_effector",
    "test_interlock_table",
    "test_program",
    "test_disk",
)
"""These groups begin first, so that no worker is left alone with one of them in the end."""


def pytest_configure() -> None:
    """Tests read the same descriptions again and again, also while they are collected."""
    _yaml._composed = lru_cache(maxsize=300)(_yaml._composed)


@pytest.fixture(scope="session")
def verdin() -> Description:
    """The shipped tool."""
    return load(profile_path())


@pytest.fixture(scope="session")
def _state_homes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("states")
    return (folder / str(number) for number in count())


@pytest.fixture(autouse=True)
def _state_home(_state_homes: Iterator[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """What `eehal verify` keeps is not kept in the home of whoever runs the tests; a folder is made if it is needed."""
    monkeypatch.setenv("XDG_STATE_HOME", str(next(_state_homes)))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    real = [item for item in items if item.get_closest_marker("wall") or item.get_closest_marker("ros")]
    for item in real:
        item.add_marker(pytest.mark.filterwarnings(_TCP_LEFT_OPEN))
    real.sort(
        key=lambda item: (
            _LONGEST.index(group) if (group := _group(item.nodeid)) in _LONGEST else len(_LONGEST)
        )
    )
    chosen = set(real)
    items[:] = [*real, *(item for item in items if item not in chosen)]


def pytest_collection_finish() -> None:
    """What was collected stays: the garbage collector would look at all of it again and again, a sixth of the time."""
    gc.collect()
    gc.freeze()


def pytest_runtest_setup() -> None:
    """Before each test, for a program that runs within a test sets its own, lower thresholds for the whole worker."""
    gc.set_threshold(*_COLLECT_AFTER)


def _group(name: str) -> str:
    """What one worker runs of these tests, by the name of one of them: a file, or half of those that need nodes.

    Nodes take a quarter of a processor also while nobody asks them: few sets, for as long as they are needed.
    """
    file = name.partition("::")[0]
    half = crc32(file.encode()) % 2
    if "acceptance/contract/" in file:
        return f"contract {half}" + (" in five" if "[five" in name else "")
    return f"ros {half}" if "acceptance/ros1/" in file else Path(file).stem


class Groups(LoadFileScheduling):
    """As ``--dist loadfile``, with those that need nodes in a few workers."""

    def _split_scope(self, nodeid: str) -> str:
        return _group(nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Of tests with real processes, which mostly wait."""
    took_s = min(timeit.repeat("sum(i * i for i in range(1_000_000))", number=1, repeat=3))
    return 5 if took_s < _FAST_S else 3 if took_s < 1.5 * _FAST_S else 2


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Groups | None:
    return Groups(config, log) if config.getoption("dist") == "loadfile" else None


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--failures-log", metavar="FILE", help="Append each test that failed, and why.")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Makes each report one that a worker of pytest-xdist can send: a lone surrogate in a log would end the worker."""
    report = yield
    report.sections = [
        (name, text.encode("utf-8", "backslashreplace").decode()) for name, text in report.sections
    ]
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    path = config.getoption("failures_log")
    if path and not hasattr(config, "workerinput"):  # a worker of xdist has this hook too
        failed = [each for outcome in ("failed", "error") for each in terminalreporter.stats.get(outcome, [])]
        with open(path, "a", encoding="utf-8") as log:
            log.writelines(f"{each.nodeid}\n{each.longreprtext}\n\n" for each in failed)
