"""For all tests: what a test said that had to be played once more is not lost."""

from __future__ import annotations

import pytest


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for report in terminalreporter.stats.get("rerun", []):
        terminalreporter.section(f"played once more: {report.nodeid}")
        terminalreporter.write_line(report.longreprtext)
