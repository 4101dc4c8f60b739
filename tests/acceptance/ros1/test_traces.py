"""HALMain leaves its trace in the log directory, readable while it runs and decided the same."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.verification.replay import load_trace, review, traces_of

pytestmark = [pytest.mark.ros, pytest.mark.timeout(300)]  # all that was recorded so far is decided once more


def test_hal_main_leaves_its_trace(system: Any) -> None:
    before = records(system)
    system.grip()
    system.run("Drop")
    system.until("records", lambda: records(system) > before + 5)
    steps, end = 0, None
    for path in traces_of(system.folder / "log"):  # a full disk, in another test, has interrupted them
        found = review(load_trace(path), before=end)
        assert found.ok, found.as_json()
        steps, end = steps + found.steps, found.end
    assert end is not None
    assert not end.complete
    assert steps > 0


def records(system: Any) -> int:
    """Of the newest: a node that was killed begins another one."""
    newest = max(traces_of(system.folder / "log"), key=lambda path: path.stat().st_mtime_ns)
    return len(load_trace(newest).file.records)
