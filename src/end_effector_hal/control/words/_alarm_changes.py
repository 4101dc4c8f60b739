"""What has changed in the alarms of a tool, each change once: for a terminal and for the log of the page."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from end_effector_hal.vocabulary import OVER


def alarm_changes(before: Sequence[str], now: Sequence[str]) -> Iterator[tuple[str, bool]]:
    """Each sentence that is new, and whether it says that something is over.

    An alarm that stays until it is acknowledged ends twice: it is replaced by one that begins with `OVER`, which
    a reset or a Drop removes. Only the first of these ends is told, in the words of the replacement. Which alarm it
    replaces nobody says: it is the one that has ended now and has most words in common with it.
    """
    gone = [text for text in before if text not in now and not text.startswith(OVER)]
    for text in now:
        if text in before:
            continue
        if not text.startswith(OVER):
            yield text, False
            continue
        ended = text.removeprefix(OVER)
        if gone:
            gone.remove(max(gone, key=lambda each: len(_words(each) & _words(ended))))
        yield ended, True
    for text in gone:
        yield text, True


def _words(text: str) -> set[str]:
    return set(re.findall(r"\w+", text))
