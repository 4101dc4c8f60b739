"""For all tests: what a test said that had to be run once more is not lost."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reruns-log", metavar="FILE", help="Append each test that was run again, and why it failed."
    )


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    reruns = [(each.nodeid, each.longreprtext) for each in terminalreporter.stats.get("rerun", [])]
    for name, why in reruns:
        terminalreporter.section(f"run once more: {name}")
        terminalreporter.write_line(why)
    if path := config.getoption("reruns_log"):
        with open(path, "a", encoding="utf-8") as log:
            log.writelines(f"{name}\n{why}\n\n" for name, why in reruns)
