"""Messages to the line arbiter from a seed: by the grammar of its protocol, nearly by it, and bytes beside it."""

from __future__ import annotations

import json
from random import Random
from typing import Any

from tests.support.keeping import LINES

_TEXTS = (
    "", "x", "grip", "sensors", "closed", "locked", "sensor_fault", "IL-03 unlock", "IL-13", "\ud800", "\udfff\ud800",
    "a\nb", "\x00", "\x1b[2J", "\u2028", "\u202e", "é", "😀", "x" * 64, "x" * 65, "ü" * 500, "y" * 501, "z" * 20_000,
    "a" * 32, "b" * 32, "c" * 32, "A" * 32,
)  # fmt: skip
_NUMBERS = (0, 1, -1, 2**31, 10**17, -(10**17), 10**18, 2**63, -(2**64), 10**400, -(10**4200), 600_000_000)
_RAW = (
    b"1" * 4300,
    b"-" + b"9" * 5000,
    b"1e999",
    b"1.5",
    b"NaN",
    b"-Infinity",
    b'"\\ud800"',
    b"[" * 2000,
    b"null",
)
_JUNK = (
    b"\n",
    b"{}\n",
    b"[]\n",
    b"\xff\xfe\x00\n",
    b'{"op":\n',
    b"{" * 5000 + b"\n",
    b"\x00" * 3000 + b"\n",
    b"q" * 70_000,
)
_OPS = ("hello", "set", "renew", "levels", "status", "bye", "tell", "latch", "clear", "reset", "stop", "fly")


class Grammar:
    """Messages one after the other; ``at`` is the time that they speak of."""

    def __init__(self, random: Random) -> None:
        self._random = random

    def message(self, at: int) -> bytes:
        """A line, mostly; sometimes a part of one."""
        choice = self._random.random()
        if choice < 0.08:
            return self._random.choice(_JUNK)
        if choice < 0.16:
            return self._random.randbytes(self._random.randrange(300)) + self._random.choice((b"", b"\n"))
        line = self._replaced(json.dumps(self._fields(at)).encode()) + b"\n"
        if choice < 0.24:
            return line[: self._random.randrange(len(line))]
        return line * (self._random.randrange(2, 400) if choice < 0.28 else 1)

    def _fields(self, at: int) -> dict[str, Any]:
        random = self._random
        op = random.choice(_OPS)
        well: dict[str, Any] = {
            "hello": {"client": self._text(), "token": random.choice(_TEXTS[-4:]), "lines": self._lines()},
            "set": {"levels": {line: random.random() < 0.5 for line in self._lines()}},
            "tell": {
                "predicates": {"locked": False, "closed": False},
                "at_us": at - random.choice((0, 1, -1, 10**6)),
            },
            "clear": {"fault": random.choice(("sensor_fault", self._text()))},
            "latch": {"fault": random.choice(("sensor_fault", self._text())), "why": self._text()},
        }.get(op, {})
        if op == "hello" and random.random() < 0.4:
            well["role"] = random.choice(("sensors", "sensors", self._value(2)))
        if op in ("hello", "set", "bye") and random.random() < 0.7:
            well["will"] = self._will()
        fields = {"op": op, "id": random.choice((1, 1, 1, "a", self._value(1))), **well}
        if op == "set" and random.random() < 0.3:
            fields["until_us"] = random.choice((at, at + 10**6, self._value(1)))
        for _ in range(random.choice((0, 0, 0, 1, 2))):
            fields[random.choice((*fields, self._text()))] = self._value(3)
        return fields

    def _replaced(self, line: bytes) -> bytes:
        """A value in it that Python would not write."""
        if self._random.random() < 0.85:
            return line
        return line.replace(self._random.choice((b"1", b"true", b'"x"', b"[]")), self._random.choice(_RAW), 1)

    def _lines(self) -> list[str]:
        some = self._random.sample(LINES, self._random.randrange(len(LINES) + 1))
        return some + ([self._text()] if self._random.random() < 0.1 else [])

    def _will(self) -> object:
        if self._random.random() < 0.15:
            return self._value(3)
        random = self._random
        steps = [
            {
                "line": line if random.random() < 0.9 else self._text(),
                "level": random.random() < 0.1,
                "after_us": random.choice((0, 1000, 10**6, 10**7, 600 * 10**6)),
            }
            for line in self._lines()
        ]
        return sorted(steps, key=lambda step: int(step["after_us"])) * self._random.choice((1, 1, 30))

    def _text(self) -> str:
        if self._random.random() < 0.7:
            return self._random.choice(_TEXTS)
        return "".join(chr(self._random.randrange(0x3000)) for _ in range(self._random.randrange(12)))

    def _value(self, depth: int) -> Any:
        kind = self._random.randrange(7 if depth else 5)
        if kind < 2:
            return self._text()
        if kind < 5:
            return (self._random.choice(_NUMBERS[:-2] + _NUMBERS[-1:]), None, self._random.random() < 0.5)[
                kind - 2
            ]
        count = self._random.choice((0, 1, 3, 100))
        if kind == 5:
            return [self._value(depth - 1) for _ in range(count)]
        return {self._text(): self._value(depth - 1) for _ in range(count)}
