"""Text from outside, made printable, so that it can be logged and published as UTF-8; and times in integer µs."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST_NAME, LONGEST_SENTENCE = 64, 500


def is_name(given: object) -> bool:
    """Return whether the object is a text of 1 to 64 printable characters.

    Control characters and halves of surrogate pairs are not printable.
    """
    return isinstance(given, str) and 0 < len(given) <= LONGEST_NAME and given.isprintable()


def printable(text: str, longest: int = LONGEST_SENTENCE) -> str:
    """Return the text with a question mark for each character that cannot be shown.

    A text that is too long ends in an ellipsis.
    """
    if len(text) > longest:
        text = f"{text[: longest - 1]}…"
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else " " if each.isspace() else "?" for each in text)


def escaped(text: str) -> str:
    """Return the text with escapes for characters that cannot be shown, so that its author can find them."""
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


def hint(word: str, known: Iterable[str]) -> str:
    """Return " (did you mean …?)" for a sentence about an unknown name; empty if no known name is similar."""
    close = get_close_matches(word, [each for each in known if each], n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def to_us(seconds: float) -> int:
    """Convert seconds to whole microseconds."""
    return round(seconds * 1_000_000)


def to_s(us: int) -> float:
    """Convert microseconds to seconds."""
    return us / 1_000_000
