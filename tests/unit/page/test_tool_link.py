"""Commands of the page where the system gives no thread."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path
from typing import Any, cast

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.page.link import ToolLink


def test_a_stop_needs_no_new_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    link = ToolLink(load(profile_path()).with_socket(tmp_path / "socket"), cast(Any, None))
    monkeypatch.setattr(threading.Thread, "start", start)
    answer = asyncio.run(link.command("stop"))
    assert answer.reason.startswith("The stop is not latched: ")  # for there is no line arbiter
