"""The one refusal that says when to ask again."""

from __future__ import annotations

from end_effector_hal.errors import LineBusyError


class LastWillRunsError(LineBusyError):
    """The last will of the client that had these lines is still being executed.

    Args:
        what: one sentence.
        retry_us: how long that takes, µs; say hello again after it.
    """

    def __init__(self, what: str, retry_us: int) -> None:
        super().__init__(what)
        self.retry_us = retry_us
