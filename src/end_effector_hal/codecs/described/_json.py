"""Lines of JSON: an object in each, with values found by their path."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

from end_effector_hal.codecs.described._codec import SerialLine, by_place
from end_effector_hal.codecs.described._text import TRUTH, DescribedLines, LineDecoder, Place
from end_effector_hal.description import NUMBER, Channel

LONGEST, OF_A_VALUE, DEEPEST = 2048, 64, 16
"""Longest line, bytes: the larger of the first number and of the second one times the number of values; and levels."""
_BRACKETS = re.compile(r"[\[{\]}]")


class DescribedJson(DescribedLines):
    """The codec of declared lines of JSON.

    Args:
        channels: the channels in them.
        line: settings of the link.
    """

    def __init__(self, channels: Mapping[str, Channel], line: SerialLine) -> None:
        super().__init__(by_place(channels, "json"), line, of_a_value=7)  # "a":1,

    def decoder(self) -> JsonDecoder:
        """Return a new decoder."""
        return JsonDecoder(self)

    def line(self, texts: Sequence[bytes]) -> bytes:
        """Return the object with these texts."""
        tree: dict[str, Any] = {}
        for place, text in zip(self.places, texts, strict=True):
            inside, (*outer, last) = tree, place_path(place)
            for key in outer:
                inside = inside.setdefault(key, {})
            if text:
                inside[last] = text.decode()
        return _written(tree).encode() + b"\r\n"


class JsonDecoder(LineDecoder):
    """Decodes lines of JSON. The end of a line is no object, so that it is never mistaken for a line."""

    def __init__(self, codec: DescribedJson) -> None:
        longest = max(LONGEST, OF_A_VALUE * len(codec.places))
        super().__init__(codec, start=b"", marked=True, longest=longest)
        self._paths = tuple(map(place_path, self._places))

    def _texts(self, line: bytes) -> Sequence[bytes] | str:
        """See `LineDecoder`; wrong are lines without an object, with a key twice, NaN, Infinity or too many levels."""
        try:
            text = line.decode()
            depth = 0
            for bracket in _BRACKETS.findall(text):
                depth += 1 if bracket in "[{" else -1
                if depth > DEEPEST:
                    return "format"
            found = json.loads(
                text,
                object_pairs_hook=_without_repetition,
                parse_float=str,
                parse_int=str,
                parse_constant=_refused,
            )
        except (ValueError, RecursionError):  # brackets in a text may hide how deep it is
            return "format"
        return [_found(found, path) for path in self._paths] if isinstance(found, dict) else "format"


def place_path(place: Place) -> tuple[str, ...]:
    """Return the keys that lead to a value."""
    return tuple((place.key or "").split("."))


def _found(inside: Any, path: Iterable[str]) -> bytes:
    """Return the text at a path: of a number, a string, true or false; b"" for null or nothing."""
    for key in path:
        if isinstance(inside, list):
            inside = inside[int(key)] if key.isdecimal() and int(key) < len(inside) else None
        else:
            inside = inside.get(key) if isinstance(inside, dict) else None
    if isinstance(inside, bool):
        return str(inside).lower().encode()
    if inside is None:
        return b""
    return inside.strip().encode(errors="replace") if isinstance(inside, str) else b"{}"


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError
    return found


def _refused(constant: str) -> NoReturn:
    raise ValueError(constant)


def _written(tree: Any) -> str:
    """Return the JSON of texts in objects; keys that are all numbers are the places of a list."""
    if isinstance(tree, str):
        return tree if NUMBER.fullmatch(tree) or tree in TRUTH else json.dumps(tree)
    if tree and all(key.isdecimal() for key in tree):
        found = {int(key): _written(each) for key, each in tree.items()}
        return f"[{','.join(found.get(place, 'null') for place in range(max(found) + 1))}]"
    return f"{{{','.join(f'{json.dumps(key)}:{_written(each)}' for key, each in tree.items())}}}"
