"""For all tests: their reports reach whoever started them, and those of tests that were run once more are kept."""

from __future__ import annotations

from collections.abc import Generator

import pytest

from end_effector_hal.description import Description, load, profile_path

_TCP_LEFT_OPEN = (
    "ignore:Exception ignored in. <socket.socket fd=[0-9]+, family=2:pytest.PytestUnraisableExceptionWarning"
)
"""rospy leaves TCP sockets to the garbage collector, also while later tests of a worker run; ours are Unix sockets."""


@pytest.fixture(scope="session")
def verdin() -> Description:
    """The shipped tool."""
    return load(profile_path())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("wall") or item.get_closest_marker("ros"):
            item.add_marker(pytest.mark.filterwarnings(_TCP_LEFT_OPEN))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reruns-log", metavar="FILE", help="Append each test that was run again, and why it failed."
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Makes each report one that a worker of pytest-xdist can send: a lone surrogate in a log would end the worker."""
    report = yield
    report.sections = [
        (name, text.encode("utf-8", "backslashreplace").decode()) for name, text in report.sections
    ]
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    reruns = [(each.nodeid, each.longreprtext) for each in terminalreporter.stats.get("rerun", [])]
    for name, why in reruns:
        terminalreporter.section(f"run once more: {name}")
        terminalreporter.write_line(why)
    if path := config.getoption("reruns_log"):
        with open(path, "a", encoding="utf-8") as log:
            log.writelines(f"{name}\n{why}\n\n" for name, why in reruns)
