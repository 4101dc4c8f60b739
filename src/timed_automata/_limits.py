"""How large a UPPAAL file may be: more is refused with a sentence, before it costs time or memory."""

from __future__ import annotations

FILE_BYTES = 500_000
XML_DEPTH = 16
"""Elements within each other."""
XML_ELEMENTS = 20_000
TEXT_CHARACTERS = 65_536
"""Of one declaration or label."""
NESTING = 500
"""Brackets within each other, signs before one operand, or operators beside each other."""
DIGITS = 10
"""Of a number; UPPAAL computes with 32 bits."""
LONGEST_BITS = 64
"""Of a number that is computed from others before anything runs."""
REPEATS = 10_000
"""Values that quantifiers and loops within each other run through together, those of called functions included."""
SELECTED = 10_000
"""Combinations of selected values of one edge."""
ELEMENTS = 100_000
"""Scalars and elements of all arrays that are declared, together."""
PROCESSES = 1_000
"""On the system line."""
PARTS = 50_000
"""Locations and edges of all processes together, an edge for each value that it selects."""
