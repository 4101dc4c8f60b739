"""The log line about a command that was not executed."""

from __future__ import annotations

import logging

from end_effector_hal.control import Answer, refused, unanswered


def logged(log: logging.Logger, what: str, answer: Answer) -> Answer:
    """Return the answer; log one line if the command was refused, or not answered in time."""
    if not answer.accepted:
        said = refused if answer.decided else unanswered
        log.info("%s", said(what, answer.reason))
    return answer
