"""A simulated tool, `eehal run` with it, `eehal page`, and a real browser; processes are those that a user starts."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import IO

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_lab.demo import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import wait_until

BROWSER = os.environ.get("EEHAL_BROWSER", "")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Without a browser they are left out."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.skipif(not BROWSER, reason="takes a browser: make test-page"))


class Process:
    """One `eehal` with its output in a file."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.log = folder / f"{words[0]}.log"
        self._out: IO[bytes] = self.log.open("wb")
        self.child = subprocess.Popen(
            [*EEHAL, *words], stdin=subprocess.PIPE, stdout=self._out, stderr=subprocess.STDOUT
        )

    def said(self, pattern: str) -> re.Match[str]:
        """Wait for it."""

        def found() -> re.Match[str] | None:
            text = self.log.read_text()
            assert self.child.poll() is None, text
            return re.search(pattern, text)

        return wait_until(f"{pattern} in {self.log}", found)

    def end(self, number: signal.Signals = signal.SIGTERM) -> None:
        """End it, and wait for that."""
        with suppress(ProcessLookupError):
            self.child.send_signal(number)
        assert self.child.stdin is not None
        with suppress(OSError):
            self.child.stdin.close()
        self.child.wait(30)
        self._out.close()


class Live:
    """A tool on virtual wires (default: the paper's), its HAL and its page, which gets these further options."""

    def __init__(self, folder: Path, scenario: str, *options: str, tool: Description | None = None) -> None:
        self.folder, self._options = folder, options
        self.world = World(tool or load(profile_path()), scenario, folder)

    def __enter__(self) -> Live:
        with ExitStack() as undo:
            undo.enter_context(self.world)
            self.hal = self.start_hal()
            undo.callback(lambda: self.hal.end())  # the one that runs then
            self.page = Process(
                self.folder, "page", str(self.world.description_path), "--port", "0", *self._options
            )
            undo.callback(self.page.end)
            self.url = self.page.said(r"http://\S+")[0]
            self._undo = undo.pop_all()
        return self

    def start_hal(self) -> Process:
        return Process(self.folder, "run", str(self.world.description_path))

    def __exit__(self, *_: object) -> None:
        self._undo.close()


@pytest.fixture(scope="session")
def chromium() -> Iterator[object]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield browser
        browser.close()
