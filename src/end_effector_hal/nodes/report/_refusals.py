"""The log line about a command that was not executed."""

from __future__ import annotations

import logging

from end_effector_hal.control import Answer, refused, unanswered


def log_refusal(log: logging.Logger, what: str, answer: Answer) -> None:
    """Log one line about a command that was refused, or not answered in time."""
    said = refused if answer.decided else unanswered
    log.info("%s", said(what, answer.reason))
