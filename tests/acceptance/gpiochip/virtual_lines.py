"""The reference recordings: the same scenarios on virtual lines and a pty, without ROS."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog, read_states
from end_effector_lab.processes import EEHAL
from tests.acceptance.gpiochip.priority import GUEST, MEMORY, before_others

LONGEST_S = 300.0
TIMES = 2
"""Its time-outs are to be taken within 100 ms, and a reading may not be late: a busy machine may miss that once."""


class OnVirtualLines:
    """Records each scenario when it is first asked for.

    Args:
        tool: the description; for the recordings its own lines and port are not used.
        folder: gets a folder for each.
    """

    def __init__(self, tool: Description, folder: Path) -> None:
        self.tool, self._folder = tool, folder
        self._recordings: dict[str, StatesLog] = {}

    def recording(self, name: str) -> StatesLog:
        """Of this scenario; fails when it does not tell its story."""
        if name not in self._recordings:
            self._recordings[name] = self._record(name)
        return self._recordings[name]

    def forget(self, name: str) -> None:
        """Have it recorded again."""
        self._recordings.pop(name, None)

    def _record(self, name: str) -> StatesLog:
        said = ""
        for _ in range(TIMES):
            # in memory: a virtual line is a file, and a busy disk would make it slow
            with tempfile.TemporaryDirectory(prefix="eehal-", dir=MEMORY) as place:
                ended = subprocess.run(
                    [
                        *before_others(GUEST), *EEHAL, "demo", str(self.tool.source), "--no-ros", "--no-figures",
                        "--only", name, "-o", f"{place}/runs",
                    ],
                    env={**os.environ, "TMPDIR": place},
                    capture_output=True, text=True, timeout=LONGEST_S, check=False,
                )  # fmt: skip
                shutil.rmtree(self._folder / name, ignore_errors=True)
                shutil.copytree(f"{place}/runs/{name}", self._folder / name)
            if ended.returncode == 0:
                return read_states(self._folder / name / "states.csv")
            said += ended.stdout + ended.stderr
        raise AssertionError(f"{name} on virtual lines, {TIMES} times:\n{said}")
