"""The address of a GPIO line: a name, or a chip and an offset, in one text everywhere beyond the YAML file."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, Field, WithJsonSchema

from ._base import PRINTABLE
from ._conditions import stanza_fault

LAST_OFFSET = 0xFFFF
LONGEST = 64


class LineAddress(NamedTuple):
    """A line by its chip and its offset there, for a board that gives its lines no names.

    Its text is ``gpiochip3:4``: any text that ends in a colon and a number is an address, never a name.

    Attributes:
        chip: name (gpiochip3), label (mcp23017) or path of the chip; ``/dev/`` in front is left out.
        offset: from 0 on.
    """

    chip: str
    offset: int

    def __str__(self) -> str:
        return f"{self.chip.removeprefix('/dev/')}:{self.offset}"

    @classmethod
    def of(cls, line: str) -> LineAddress | None:
        """Return the address that a text contains; None: the text is a name."""
        chip, _, offset = line.rpartition(":")
        return cls(chip, int(offset)) if chip and offset.isascii() and offset.isdecimal() else None


def line_text(given: Any) -> Any:
    """Return the one text of a line that a description gives by name, or by chip and offset.

    Anything else is returned unchanged; an address with wrong keys raises the fault of the stanza.
    """
    if isinstance(given, str):
        return str(LineAddress.of(given) or given)
    if not isinstance(given, dict):
        return given
    chip, offset = given.get("chip"), given.get("offset")
    right = isinstance(chip, str) and chip and type(offset) is int and 0 <= offset <= LAST_OFFSET
    if set(given) != {"chip", "offset"} or not right:
        expected = f"a name, or {{chip: gpiochip3, offset: 4}} with an offset from 0 to {LAST_OFFSET}"
        raise stanza_fault("EE-207", "this is no GPIO line", expected)
    return str(LineAddress(str(chip), int(offset or 0)))


LineName = Annotated[
    str,
    Field(pattern=PRINTABLE, min_length=1, max_length=LONGEST),
    BeforeValidator(line_text),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": PRINTABLE, "minLength": 1, "maxLength": LONGEST},
                {
                    "type": "object",
                    "properties": {
                        "chip": {"type": "string", "minLength": 1},
                        "offset": {"type": "integer", "minimum": 0, "maximum": LAST_OFFSET},
                    },
                    "required": ["chip", "offset"],
                    "additionalProperties": False,
                },
            ]
        }
    ),
]
"""A GPIO line: its name, or the text of a `LineAddress`."""
