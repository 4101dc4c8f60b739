"""What the workers of the tests do: they find it by its name."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def add(shared: int, item: int) -> int:
    return shared + item


def die(fatal: int, item: int) -> int:
    if item == fatal:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def slow(folder: Path, item: int) -> int:
    (folder / str(item)).touch()
    time.sleep(0.05)
    return item


def fail(_: object, item: int) -> int:
    raise ValueError(f"no {item}")


class NotThere:
    """Of a package that is installed on one side only."""

    def __reduce__(self) -> tuple[object, tuple[str, ...]]:
        return __import__, ("eehal_not_there",)
