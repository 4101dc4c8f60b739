"""How a program of the nodes ends: an error is one sentence, and the exit code says its kind."""

from __future__ import annotations

import sys
from collections.abc import Callable

from end_effector_hal.errors import ReportedError


def guarded(name: str, body: Callable[[], int | None]) -> int:
    """Call ``body`` and return the exit code; ``name`` stands before the sentence of an error."""
    try:
        return int(body() or 0)
    except ReportedError as error:
        print(f"{name}: {error}", file=sys.stderr)  # noqa: T201 there is no logger before a node is up
        return error.exit_code
    except KeyboardInterrupt:
        return 130
