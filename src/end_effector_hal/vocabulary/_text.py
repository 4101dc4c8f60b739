"""Text from outside: what is shown to people, logged, published or written down can always be written as UTF-8."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST_NAME, LONGEST_SENTENCE = 64, 500


def is_name(given: object) -> bool:
    """Whether it is a text of 1 to 64 printable characters: no control characters, no half of a surrogate pair."""
    return isinstance(given, str) and 0 < len(given) <= LONGEST_NAME and given.isprintable()


def printable(text: str, longest: int = LONGEST_SENTENCE) -> str:
    """The text with a question mark for each character that cannot be shown; what is too long ends in an ellipsis."""
    if len(text) > longest:
        text = f"{text[: longest - 1]}…"
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else " " if each.isspace() else "?" for each in text)


def escaped(text: str) -> str:
    """The text with escapes for what cannot be shown: for what was written by the reader, who is to find it."""
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


def hint(word: str, known: Iterable[str]) -> str:
    """For a sentence about a name that is not known: " (did you mean …?)"; empty if no known one is near."""
    close = get_close_matches(word, [each for each in known if each], n=1)
    return f" (did you mean {close[0]}?)" if close else ""
