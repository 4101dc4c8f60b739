"""The joint answer to a reset."""

from __future__ import annotations

from collections.abc import Iterable

from .._status import Answer

NOTHING_LATCHED = (
    "No fault is latched any more. GRIP_ERROR or RELEASE_ERROR needs a Drop, or after a loss a resume."
)


def reset_answer(answers: Iterable[Answer]) -> Answer:
    """Return the joint answer to a reset from the answers of all that latch faults."""
    stays = [answer for answer in answers if not answer.accepted]
    if not stays:
        return Answer(True, NOTHING_LATCHED)
    reason = " ".join(dict.fromkeys(answer.reason for answer in stays))
    return Answer(False, reason, decided=all(answer.decided for answer in stays))
